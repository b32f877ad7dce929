"""Open3D's RGB-D odometry on the frames of an .npz file; prints steps and times as JSON.

In an environment of its own (peers-tracking.txt): python open3d_worker.py FRAMES.npz color|hybrid
"""

import json
import os
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"  # before the import reads it

import numpy as np
import open3d as o3d


def rgbd(grey: np.ndarray, depth: np.ndarray) -> o3d.geometry.RGBDImage:
    # as create_from_color_and_depth leaves them: intensity 0..1, depth in m, 0 where there is none
    image = o3d.geometry.Image(grey.astype(np.float32) / 255.0)
    metres = np.nan_to_num(depth).astype(np.float32)
    result = o3d.geometry.RGBDImage()
    result.color = image
    result.depth = o3d.geometry.Image(metres)
    return result


def main() -> None:
    data = np.load(sys.argv[1])
    jacobian = {
        "color": o3d.pipelines.odometry.RGBDOdometryJacobianFromColorTerm,
        "hybrid": o3d.pipelines.odometry.RGBDOdometryJacobianFromHybridTerm,
    }[sys.argv[2]]()
    K, grey, depth = data["K"], data["grey"], data["depth"]
    height, width = grey.shape[1:]
    camera = o3d.camera.PinholeCameraIntrinsic(width, height, K[0, 0], K[1, 1], K[0, 2], K[1, 2])
    option = o3d.pipelines.odometry.OdometryOption()
    steps, seconds = [], []
    before = rgbd(grey[0], depth[0])
    for image, metres in zip(grey[1:], depth[1:], strict=True):
        start = time.perf_counter()
        here = rgbd(image, metres)
        ok, T, _ = o3d.pipelines.odometry.compute_rgbd_odometry(
            before, here, camera, np.eye(4), jacobian, option
        )
        seconds.append(time.perf_counter() - start)
        steps.append([bool(ok), np.asarray(T).tolist()])
        before = here
    print(json.dumps({"version": o3d.__version__, "steps": steps, "seconds": seconds}))


if __name__ == "__main__":
    main()
