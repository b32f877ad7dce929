"""Milliseconds per rendered frame, one thread: python benchmarks/render.py [--repeats 7]."""

import argparse
import statistics
import time

import numpy as np

from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.synthetic import RenderOptions, SensorOptions

CAMERA = PinholeCamera(525.0, 525.0, 319.5, 239.5)
SCENES = {
    "plane": synthetic.plane(),
    "room": synthetic.room(),
    "boxes": synthetic.boxes(),
    "sphere": synthetic.sphere(),
    "height_field": synthetic.height_field(),
}
MODES = {
    "none": RenderOptions(antialiasing="none"),
    "bandlimit": RenderOptions(),
    "supersample 2x2": RenderOptions(antialiasing="supersample", supersampling=2),
}
NOISY = SensorOptions(read_noise=1.0, shot_noise=0.02)


def milliseconds(call, repeats: int) -> float:
    """Median over `repeats` calls, after one that warms up."""
    call()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def measure(repeats: int) -> dict[str, dict[str, float]]:
    """ms per frame of 640 x 480 by scene and mode; under `sensor` what a frame's noise adds."""
    result: dict[str, dict[str, float]] = {}
    for name, scene in SCENES.items():
        result[name] = {
            mode: milliseconds(
                lambda scene=scene, options=options: synthetic.render(
                    scene, CAMERA, np.eye(4), width=640, height=480, options=options
                ),
                repeats,
            )
            for mode, options in MODES.items()
        }
    frame = synthetic.render(SCENES["room"], CAMERA, np.eye(4), width=640, height=480)
    result["sensor"] = {
        "noise": milliseconds(lambda: synthetic.expose(frame.irradiance, options=NOISY), repeats),
        "depth camera": milliseconds(lambda: synthetic.sense_depth(frame, CAMERA), repeats),
    }
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=7)
    measured = measure(parser.parse_args().repeats)
    print("640x480, 60 waves, one thread; ms per frame, image, depth, normals and faces included")
    for name, row in measured.items():
        print(f"{name:14}" + "".join(f"{mode:>18} {value:6.1f}" for mode, value in row.items()))


if __name__ == "__main__":
    main()
