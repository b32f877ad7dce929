"""From how far the alignment finds its way: start error against success."""

from pathlib import Path

import numpy as np

from raylign import geometry, synthetic
from raylign.tracking import GradientMode, TrackingOptions, align
from tracking import accuracy, frames

NUM_LEVELS = 5
TRANSLATION_SHARE, ANGLE_DEG = 0.04, 3.0  # the two balls of the issue
# Rounding of poses to float32 in the kernels: an error below this is none, whatever the exact
# start reached
FLOOR_M, FLOOR_DEG = 1e-5, 3e-4
MAP_TRANSLATION = np.linspace(0.0, 0.24, 9)  # share of the mean depth, edges of the cells
MAP_ANGLE = np.linspace(0.0, 16.0, 9)  # degrees


class Basin:
    """The room, seed 0: a target 2.7 cm and 1.4 degrees from the keyframe."""

    def __init__(self) -> None:
        scene = synthetic.room(seed=0)
        host = accuracy.render(scene, np.eye(4))
        self.mean_depth = float(np.nanmean(host.depth))
        self.keyframe = accuracy.exact_keyframe(host)
        self.truth = accuracy.motion(*accuracy.MOTIONS[0], np.random.default_rng(0))
        self.image = accuracy.render(scene, self.truth).image

    def start(self, upsilon: np.ndarray, omega: np.ndarray) -> np.ndarray:
        offset = geometry.se3_exp(np.concatenate([np.zeros(3), omega]))
        offset[:3, 3] = upsilon
        return offset @ self.truth

    def run(self, T_init: np.ndarray, options: TrackingOptions) -> tuple[bool, float, float]:
        result = align(self.keyframe, self.image, T_init=T_init, options=options)
        return result.ok, *frames.pose_error(result.T_th, self.truth)

    def goal(self, options: TrackingOptions) -> tuple[float, float]:
        """Twice the error of the exact start."""
        _, metres, degrees = self.run(self.truth, options)
        return max(2 * metres, FLOOR_M), max(2 * degrees, FLOOR_DEG)


def tracking_options(levels: int, esm: bool) -> TrackingOptions:
    gradient = GradientMode.ESM if esm else GradientMode.FORWARD
    return TrackingOptions(finest_level=0, coarsest_level=levels - 1, gradient=gradient)


def measure(repeats: int) -> dict:
    """`repeats` starts uniform in the two balls; 5 levels, both gradients."""
    basin = Basin()
    rows = []
    for esm in (False, True):
        options = tracking_options(NUM_LEVELS, esm)
        goal = basin.goal(options)
        random = np.random.default_rng(0)
        found = []
        for _ in range(repeats):
            upsilon = TRANSLATION_SHARE * basin.mean_depth * accuracy.ball(random)
            omega = np.deg2rad(ANGLE_DEG) * accuracy.ball(random)
            found.append(basin.run(basin.start(upsilon, omega), options))
        hits = [metres <= goal[0] and degrees <= goal[1] for _, metres, degrees in found]
        rows.append(
            {
                "gradient": "esm" if esm else "forward",
                "starts": repeats,
                "successes": sum(hits),
                "ok": sum(ok for ok, *_ in found),
                "ok_but_not_there": sum(
                    ok and not hit for (ok, *_), hit in zip(found, hits, strict=True)
                ),
                "goal_mm": 1e3 * goal[0],
                "goal_deg": goal[1],
            }
        )
    return {"mean_depth_m": basin.mean_depth, "rows": rows}


def measure_map(per_cell: int) -> dict:
    """Share of successes over start errors, for 1 to 5 levels and both gradients."""
    basin = Basin()
    panels = []
    for esm in (False, True):
        for levels in range(1, NUM_LEVELS + 1):
            options = tracking_options(levels, esm)
            goal = basin.goal(options)
            rate = np.zeros((len(MAP_ANGLE) - 1, len(MAP_TRANSLATION) - 1))
            lies = 0
            for row, column in np.ndindex(*rate.shape):
                random = np.random.default_rng([row, column])
                for _ in range(per_cell):
                    share = random.uniform(*MAP_TRANSLATION[column : column + 2])
                    angle = random.uniform(*np.deg2rad(MAP_ANGLE[row : row + 2]))
                    upsilon, omega = (_direction(random) for _ in range(2))
                    start = basin.start(share * basin.mean_depth * upsilon, angle * omega)
                    ok, metres, degrees = basin.run(start, options)
                    hit = metres <= goal[0] and degrees <= goal[1]
                    rate[row, column] += hit / per_cell
                    lies += ok and metres > accuracy.WRONG_M
            panels.append(
                {"esm": esm, "levels": levels, "rate": rate.tolist(), "ok_but_wrong": int(lies)}
            )
    return {
        "per_cell": per_cell,
        "translation_share": MAP_TRANSLATION.tolist(),
        "angle_deg": MAP_ANGLE.tolist(),
        "panels": panels,
    }


def _direction(random: np.random.Generator) -> np.ndarray:
    vector = random.normal(size=3)
    return vector / np.linalg.norm(vector)


def draw(result: dict, path: Path) -> None:
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, NUM_LEVELS, figsize=(12.0, 5.4), sharex=True, sharey=True,
                                layout="constrained")  # fmt: skip
    x = 100 * np.array(result["translation_share"])
    y = np.array(result["angle_deg"])
    for panel in result["panels"]:
        axis = axes[int(panel["esm"]), panel["levels"] - 1]
        image = axis.pcolormesh(x, y, panel["rate"], vmin=0.0, vmax=1.0, cmap="viridis")
        plural = "" if panel["levels"] == 1 else "s"
        gradient = "ESM" if panel["esm"] else "forward"
        axis.set_title(f"{panel['levels']} level{plural}, {gradient}", fontsize=10)
        inside_x, inside_y = 100 * TRANSLATION_SHARE, ANGLE_DEG
        axis.plot([0, inside_x, inside_x], [inside_y, inside_y, 0], color="white", lw=1.2)
    figure.supxlabel("start error, translation / % of the mean depth")
    figure.supylabel("start error, rotation / degrees")
    bar = figure.colorbar(image, ax=axes, shrink=0.8)
    bar.set_label("share of starts that end within\ntwice the error of the exact start")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)
    plt.close(figure)
