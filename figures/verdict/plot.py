"""Draws the figure from results.json, and prints its table.

python -m figures.verdict.plot
"""

import json

import numpy as np

from figures import results, style
from figures.verdict.compute import FOLDER, INTERFACES

#: What methods have by construction: noise, bottoms, gradients, languages of real-time shaders.
HAVE = {
    "networks": "no | any BSDF | yes | GLSL, HLSL, WGSL, OSL",
    "walk": "yes | any BSDF | no | no",
    "Belcour 2018": "no | conductors and diffuse | no | no",
    "Weidlich and Wilkie 2007": "no | any BSDF | no | no",
}


def main() -> None:
    """Draw the figure and print the table."""
    found = json.loads((FOLDER / "results.json").read_text())
    picture = style.figure(6.4, 3.8)
    axis = picture.subplots()
    colours = style.COLOURS | {
        "walk": style.COLOURS["reference"],
        "Weidlich and Wilkie 2007": style.COLOURS["exact"],
    }
    for name in HAVE:
        values = np.array(found["interfaces_2"][name])
        mean, bounds = values.mean(), results.interval(values)
        axis.errorbar(
            found["costs"]["textured"][name],
            100 * mean,
            yerr=100 * np.abs(np.array(bounds) - mean)[:, None],
            marker="o",
            capsize=3,
            linestyle="",
            color=colours[name],
            label="walk (its own noise)" if name == "walk" else name,
        )
    axis.set(yscale="log", ylabel="E over two interfaces [%]")
    axis.set_xlabel("CPU time of a textured render, over that of principled")
    axis.set_xlim(0, 1.1 * max(found["costs"]["textured"].values()))
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, loc="center right")
    style.save(picture, FOLDER / "figure.png")
    print("\n".join(table(found)))


def table(found) -> list[str]:
    """Lines of a Markdown table: one for each method."""
    errors = [f"E, {n} interfaces" for n in INTERFACES]
    lines = [
        "| method | "
        + " | ".join(errors)
        + " | not reciprocal | largest albedo | constant | textured |",
        "|---" * (len(errors) + 5) + "|",
    ]
    for name in HAVE:
        cells = [name]
        for n in INTERFACES:
            e = 100 * np.array(found[f"interfaces_{n}"][name])
            low, high = results.interval(e)
            cells.append(f"{e.mean():.2g} % ({low:.2g} to {high:.2g})")
        if name == "walk":
            cells += ["0", "1"]
        else:
            exchange = 100 * max(found[f"interfaces_{n}"][f"{name}, exchange"] for n in INTERFACES)
            cells += [f"{exchange:.2g} %" if exchange > 1e-3 else "0", f"{found['laws'][name]:.2f}"]
        cells += [f"{found['costs'][kind][name]:.2g}" for kind in ("constant", "textured")]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", "| method | noise | bottoms | gradients | shaders |"]
    lines.append("|---" * 5 + "|")
    return lines + [f"| {name} | {have} |" for name, have in HAVE.items()]


if __name__ == "__main__":
    main()
