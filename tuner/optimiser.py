"""Proposes the next point to try: Bayesian optimisation by scikit-optimize, controlled line by line.

`sppm tune` contains this file and runs it. `sppm tune` measures points, and this process proposes them. Every line is a
JSON object. The first line on standard input defines the search space; each line after it is a request. Each of them is
answered by one line on standard output.

    {"dimensions": [...], "start": [...], "initial": 10, "seed": 1}    {"optimiser": "scikit-optimize 0.10.2"}
    {"ask": true}                                                      {"point": [...]}
    {"tell": [...], "value": -0.01}                                    {"told": 3}
    {"conclude": true}                                                 {"order": [...], "noise": 0.01, ...}

The model is a Gaussian process with a Matern kernel (5/2, one length scale per dimension) and white noise. The
acquisition function is hedged among lower confidence bound, expected improvement and probability of improvement, as in
the paper's autotuner. Smaller values are better.
"""

import json
import os
import signal
import sys

# Ctrl-C reaches both processes; `sppm tune` handles it.
signal.signal(signal.SIGINT, signal.SIG_IGN)
# Idle threads of a linear algebra library would disturb the measurements.
for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"


def answer(**fields):
    print(json.dumps(fields), flush=True)


try:
    import warnings

    import numpy
    import skopt
    from skopt.space import Categorical, Integer, Real
except ImportError as error:
    answer(missing=str(error))
    sys.exit(1)

# Two harmless warnings: trying a point again makes sense with noisy values, and a length scale at its upper bound means
# that the dimension does not matter.
warnings.simplefilter("ignore")

KINDS = {
    "real": lambda d: Real(d["least"], d["most"], prior="log-uniform"),
    "whole": lambda d: Integer(d["least"], d["most"]),
    "choice": lambda d: Categorical(d["choices"]),
}
# Points at which the acquisition is evaluated for each proposal.
CANDIDATES = 4000


def plain(value):
    """A coordinate as a type that JSON supports."""
    if isinstance(value, (bool, str)):
        return value
    return int(value) if isinstance(value, (int, numpy.integer)) else float(value)


class Search:
    """A search in progress."""

    def __init__(self, setup):
        self.dimensions = setup["dimensions"]
        self.start = setup["start"]
        self.optimizer = skopt.Optimizer(
            [KINDS[dimension["kind"]](dimension) for dimension in self.dimensions],
            base_estimator="GP",
            acq_func="gp_hedge",
            acq_optimizer="sampling",
            acq_optimizer_kwargs={"n_points": CANDIDATES},
            n_initial_points=setup["initial"],
            initial_point_generator="lhs",
            random_state=setup["seed"],
        )

    def ask(self, _):
        """The next point to try; the first one is the given start."""
        point = self.optimizer.ask() if self.optimizer.Xi else self.start
        return {"point": [plain(value) for value in point]}

    def tell(self, request):
        """Records the value measured at a point."""
        self.optimizer.tell(request["tell"], request["value"])
        return {"told": len(self.optimizer.yi)}

    def conclude(self, _):
        """The indices of all points ordered by the model's mean, best first, and the parameters of the model.

        The noise is a standard deviation. A length scale is relative to the range of its dimension; if it is large, the
        dimension does not matter.
        """
        values = numpy.array(self.optimizer.yi)
        if not self.optimizer.models:
            return {"order": numpy.argsort(values, kind="stable").tolist(), "noise": None, "length_scales": {}}
        model = self.optimizer.models[-1]
        means = model.predict(self.optimizer.space.transform(self.optimizer.Xi))
        kernel = model.kernel_.get_params()
        scales = next(value for name, value in kernel.items() if name.endswith("length_scale"))
        names = [dimension["name"] for dimension in self.dimensions]
        return {
            "order": numpy.argsort(means, kind="stable").tolist(),
            "noise": float(numpy.sqrt(model.noise_) * values.std()),
            "length_scales": dict(zip(names, numpy.atleast_1d(scales).tolist())),
            "kernel": str(model.kernel_),
        }


def main():
    search = Search(json.loads(sys.stdin.readline()))
    answer(optimiser=f"scikit-optimize {skopt.__version__}")
    for line in sys.stdin:
        request = json.loads(line)
        action = next(action for action in ("ask", "tell", "conclude") if action in request)
        answer(**getattr(search, action)(request))


if __name__ == "__main__":
    main()
