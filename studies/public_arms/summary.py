"""The lines as a page: one table, what was found, what each protocol flatters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from oed.report.table import MISSING, Row, markdown_table
from studies.public_arms.catalogue import ARMS
from studies.public_arms.judge import HORIZONS, MODELS

Line = Mapping[str, str]

EXPLAINED = (
    "Errors on the sealed rows, which neither fitted nor chose anything, in the diagnosis's band, all rows "
    "counting alike. **base**: rigid body, rotor inertias, Coulomb and viscous friction. **loop**: the "
    "same with what the diagnosis found. **feasible**: bodies that can exist, beside what was found. "
    "**peer**: the model that was published with the recording, run from its repository on the same "
    "rows, in the same band. In brackets: 95 % intervals by blocks of half a second."
)


def page(lines: Sequence[Line]) -> str:
    """The summary."""
    done = [line for line in lines if line["status"] == "done"]
    parts = ["# Public arms", EXPLAINED]
    if done:
        parts += [
            "## Relative error: rms error over rms torque, all joints together",
            markdown_table([_relative(line) for line in done]),
            verdict(done),
            "## In noise floors, in newton metres, and simulated",
            (
                f"`floors`: root mean square over the joints of error over noise. `flange`: how far the simulated "
                f"flange is from the measured one after {HORIZONS[-1]:g} s, in millimetres; a model "
                "whose mass matrix is that of no bodies has no simulation."
            ),
            markdown_table([_absolute(line) for line in done]),
            "## What is not asked of the models",
            markdown_table([_protocol(line) for line in done]),
        ]
        parts += [text for line in done for text in _found(line)]
    missing = [f"- {line['arm']}: {line['status']}" for line in lines if line["status"] != "done"]
    if missing:
        parts += ["## Not done", "\n".join(missing)]
    return "\n\n".join(parts) + "\n"


def verdict(lines: Sequence[Line]) -> str:
    """How the loop stands to the peers, counted."""
    with_peer = [line for line in lines if line["ratio_peer"]]
    if not with_peer:
        return "No published model was run."
    ends = {line["arm"]: [float(x) for x in line["ratio_peer"].split()] for line in with_peer}
    better = [arm for arm, (_, high) in ends.items() if high < 1]
    worse = [arm for arm, (low, _) in ends.items() if low > 1]
    open_ = [arm for arm in ends if arm not in better and arm not in worse]
    said = [
        f"{word}: {', '.join(arms)}"
        for word, arms in (
            ("below the published model, the whole interval", better),
            ("not to be told apart", open_),
            ("above it", worse),
        )
        if arms
    ]
    return (
        f"The loop's error on {len(ends)} arms with a published model that runs: {'; '.join(said)}."
    )


def _relative(line: Line) -> Row:
    return {
        "arm": line["arm"],
        **{name: _with_ends(line[f"relative_{name}"], line[f"interval_{name}"]) for name in MODELS},
        "loop over peer": _ends(line["ratio_peer"]),
        "seconds": line["seconds"],
    }


def _absolute(line: Line) -> Row:
    return {
        "arm": line["arm"],
        "torque": _spread(line["torque"]),
        **{
            f"{name}: rms, floors": f"{_spread(line[f'rms_{name}'])}; {line[f'floors_{name}']}"
            if line[f"rms_{name}"]
            else MISSING
            for name in MODELS
        },
        **{
            f"flange {name}": line[f"flange_{name}"].split()[-1]
            if line[f"flange_{name}"]
            else MISSING
            for name in MODELS
            if name != "peer"
        },
    }


def _protocol(line: Line) -> Row:
    arm = ARMS.get(line["arm"])
    return {
        "arm": line["arm"],
        "fitted, sealed [s]": f"{line['fitted_seconds']}, {line['sealed_seconds']}",
        "band [Hz]": line["cutoff"],
        "rows": arm.protocol if arm else "as the data set says",
        "what that flatters": (arm.flatters or "another motion") if arm else MISSING,
        "sealed rows beyond the fitted range": line["range"],
    }


def _found(line: Line) -> list[str]:
    arm = ARMS.get(line["arm"])
    peer = arm.peer if arm else None
    said = [
        (
            f"Verdict: {line['verdict']}. Named: {line['named'] or 'nothing'}. Without a name: "
            f"{line['unnamed'] or 'nothing'}."
        ),
        *([f"{line['contradicted']}."] if line["contradicted"] else []),
        *([f"Published: {peer.model}; fitted on {peer.fitted}."] if peer else []),
        *(
            [f"Not run: {peer.why_not or line['no_peer']}."]
            if peer and not line["rms_peer"]
            else []
        ),
        *([f"No feasible bodies: {line['no_feasible']}."] if line["no_feasible"] else []),
        *[
            f"{name}, joint by joint, relative: "
            + " ".join(
                f"{float(e) / float(t):.3f}"
                for e, t in zip(line[f"rms_{name}"].split(), line["torque"].split(), strict=True)
            )
            + "."
            for name in MODELS
            if line[f"rms_{name}"]
        ],
    ]
    return [f"## {line['arm']}", "\n".join(f"- {text}" for text in said)]


def _with_ends(value: str, ends: str) -> str:
    return f"{float(value):.3f} [{_ends(ends)}]" if value else MISSING


def _ends(ends: str) -> str:
    return "-".join(f"{float(x):.3f}" for x in ends.split()) if ends else MISSING


def _spread(values: str) -> str:
    """The least and the largest of the joints."""
    numbers = sorted(map(float, values.split()))
    return f"{numbers[0]:.2g}-{numbers[-1]:.2g}" if numbers else MISSING
