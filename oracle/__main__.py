"""The command line of the oracle."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from oracle import sppm
from oracle.sppm import SCENES, SCENES_WITH_TRUTH, OracleError
from oracle.ztest import Verdict

DESCRIPTION = """
What other people's code says of sppm: Embree of its intersections, OpenCV of its images, Mitsuba 3 of its light.
Exits with 0 if all agree, with 1 if something differs, with 2 if it cannot tell. The program asked is $SPPM, or the
newest of target/release/sppm and target/debug/sppm.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    args = _parser().parse_args(arguments)
    try:
        return 0 if args.run(args) else 1
    except (OracleError, ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m oracle", description=DESCRIPTION)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("intersections", help="hold `sppm trace` against Embree, by spheres and triangles")
    _scenes(command)
    command.add_argument("--rays", type=_count, default=1_000_000, help="rays per scene [default: %(default)s]")
    command.add_argument("--engine", choices=("fast", "reference"), default="fast")
    command.add_argument("--seed", type=int, default=1)
    command.set_defaults(run=_intersections)

    command = commands.add_parser("images", help="SSIM and PSNR of two image files (.pfm, .exr or .png)")
    command.add_argument("image", type=Path)
    command.add_argument("reference", type=Path)
    command.set_defaults(run=_images)

    command = commands.add_parser("ssim-series", help="SSIM over iterations against a converged image: figure 8")
    _scenes(command)
    command.add_argument(
        "--most", type=_count, default=2048, help="iterations of the last image [default: %(default)s]"
    )
    command.set_defaults(run=_ssim_series)

    command = commands.add_parser("truth", help="make truth by Mitsuba, or hold renders against it")
    command.add_argument("what", choices=("make", "check"))
    _scenes(command)
    command.add_argument("--batches", type=_count, default=32, help="make: independent images")
    command.add_argument("--samples", type=_count, default=128, help="make: samples per pixel of each of them")
    command.add_argument("--engine", choices=("fast", "reference", "path"), default="fast", help="check: whose renders")
    command.add_argument("--seeds", type=_count, default=16, help="check: independent renders")
    command.add_argument("--iterations", type=_count, default=48, help="check: iterations of each of them")
    command.add_argument("--photons", type=_count, default=50_000, help="check: photons per iteration")
    command.set_defaults(run=_truth)

    command = commands.add_parser("witness", help="hold renders against a path tracer in double precision")
    command.add_argument("scenes", nargs="*", metavar="SCENE", help="scenes [default: the lamps within glass]")
    command.add_argument("--mitsuba", action="store_true", help="show Mitsuba's renders too, which decide nothing")
    command.add_argument("--renders", type=_count, default=16, help="independent renders [default: %(default)s]")
    command.add_argument("--samples", type=_count, default=1024, help="samples per pixel [default: %(default)s]")
    command.add_argument("--iterations", type=_count, default=64, help="iterations of SPPM [default: %(default)s]")
    command.add_argument("--photons", type=_count, default=50_000, help="photons of each [default: %(default)s]")
    command.set_defaults(run=_witness)

    command = commands.add_parser("report", help="one HTML page of all verdicts, images and plots")
    command.add_argument("--output", type=Path, default=sppm.ROOT / "target" / "report" / "index.html")
    command.add_argument("--quick", action="store_true", help="less of everything: to look at the page, not at sppm")
    command.add_argument("--most", type=_count, help="iterations of the last image of figure 8 [default: 2048]")
    command.set_defaults(run=_report)
    return parser


def _scenes(command: argparse.ArgumentParser) -> None:
    command.add_argument("scenes", nargs="*", metavar="SCENE", help="built-in scenes [default: all]")


def _count(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of at least 1")
    return value


def _named(args: argparse.Namespace, usual: Sequence[str] = SCENES) -> Sequence[str]:
    return args.scenes or usual


def _intersections(args: argparse.Namespace) -> bool:
    from oracle import embree

    agree = True
    for scene in _named(args):
        for kind in embree.KINDS:
            outcome = embree.compare(scene, args.rays, kind, args.seed, "--engine", args.engine)
            print(outcome, flush=True)
            agree &= outcome.agrees
    return agree


def _images(args: argparse.Namespace) -> bool:
    from oracle import images, metrics

    print(metrics.compare(images.read(args.image), images.read(args.reference)))
    return True


def _ssim_series(args: argparse.Namespace) -> bool:
    from oracle import series

    for points in series.measure_all(_named(args), args.most):
        print(*points, sep="\n", flush=True)
    return True


def _truth(args: argparse.Namespace) -> bool:
    from oracle import judge, truth

    verdicts = []
    for scene in _named(args, SCENES_WITH_TRUTH):
        if args.what == "make":
            plan = truth.Plan(args.batches, args.samples)
            made = truth.make(scene, plan)
            truth.save(scene, made, truth.provenance(scene, plan, made))
            print(f"{scene:8} {truth.path(scene)}", flush=True)
        else:
            effort = judge.Effort(args.seeds, args.iterations, args.photons)
            _, verdict = judge.scene(scene, args.engine, effort)
            print(f"{scene:8} {args.engine:9} {verdict}", flush=True)
            verdicts.append(verdict)
    return _all_same(verdicts)


def _witness(args: argparse.Namespace) -> bool:
    from oracle import witness

    effort = witness.Effort(args.renders, args.samples, args.iterations, args.photons)
    verdicts = []
    for name in args.scenes or witness.SCENES:
        renderers = [*witness.ENGINES, *(["mitsuba"] if args.mitsuba else [])]
        for renderer, (ratio, verdict) in witness.scene(name, renderers, effort).items():
            print(f"{Path(name).stem:16} {renderer:8} {verdict}\n    over the tracer's: {ratio}", flush=True)
            verdicts += [verdict] if renderer in witness.ENGINES else []
    return _all_same(verdicts)


def _all_same(verdicts: Sequence[Verdict]) -> bool:
    """Whether all are the same. It is an error if this cannot be told."""
    undecided = sum(not (verdict.same or verdict.different) for verdict in verdicts)
    if undecided and not any(verdict.different for verdict in verdicts):
        raise OracleError(f"{undecided} of {len(verdicts)} are undecided; take more renders or longer ones")
    return all(verdict.same for verdict in verdicts)


def _report(args: argparse.Namespace) -> bool:
    from oracle import report

    args.output.parent.mkdir(parents=True, exist_ok=True)
    report.write(args.output, quick=args.quick, most=args.most)
    print(args.output)
    return True


if __name__ == "__main__":
    sys.exit(main())
