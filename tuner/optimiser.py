"""Proposes what to try next: Bayesian optimisation by scikit-optimize, asked line by line.

`sppm tune` has this file within and runs it; it measures, this proposes. Every line is a JSON object. The first line
on standard input states the space, and every line after it is a request; to each there is one line on standard output.

    {"dimensions": [...], "start": [...], "initial": 10, "seed": 1}    {"optimiser": "scikit-optimize 0.10.2"}
    {"ask": true}                                                      {"point": [...]}
    {"tell": [...], "value": -0.01}                                    {"told": 3}
    {"conclude": true}                                                 {"order": [...], "noise": 0.01, ...}

The model is a Gaussian process with a Matern kernel (5/2, a length scale per dimension) and white noise, and the
acquisition is hedged among lower confidence bound, expected improvement and probability of improvement, as in the
paper's autotuner. The smaller a value, the better.
"""

import json
import os
import signal
import sys

# Ctrl-C goes to both processes; the one that measures decides.
signal.signal(signal.SIGINT, signal.SIG_IGN)
# Threads of a linear algebra library that wait for work would disturb what is measured.
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

# That a point was tried before is no fault where values are noisy; a length scale at its bound means: does not matter.
warnings.simplefilter("ignore")

KINDS = {
    "real": lambda d: Real(d["least"], d["most"], prior="log-uniform"),
    "whole": lambda d: Integer(d["least"], d["most"]),
    "choice": lambda d: Categorical(d["choices"]),
}
# Points at which the acquisition is evaluated for each proposal.
CANDIDATES = 4000


def plain(value):
    """A coordinate as JSON knows it."""
    if isinstance(value, (bool, str)):
        return value
    return int(value) if isinstance(value, (int, numpy.integer)) else float(value)


class Search:
    """A search under way."""

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
        """The next point; the first is where one would start without a search."""
        point = self.optimizer.ask() if self.optimizer.Xi else self.start
        return {"point": [plain(value) for value in point]}

    def tell(self, request):
        """Takes the value measured at a point."""
        self.optimizer.tell(request["tell"], request["value"])
        return {"told": len(self.optimizer.yi)}

    def conclude(self, _):
        """The places of all points by the model's mean, the best first, and what the model has learnt.

        The noise is a standard deviation. A length scale is in widths of its dimension's range: a large one says that
        the dimension does not matter.
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
