"""cv2.Odometry of OpenCV 5, from frame to frame, as its documentation uses it."""

import time

import cv2
import numpy as np

TYPES = ("RGB", "DEPTH", "RGB_DEPTH")


class CvOdometry:
    """Settings at their defaults; each frame is prepared once and serves two pairs."""

    def __init__(self, kind: str, K: np.ndarray) -> None:
        settings = cv2.OdometrySettings()
        settings.setCameraMatrix(np.asarray(K, np.float32))
        self._odometry = cv2.Odometry(
            getattr(cv2, f"OdometryType_{kind}"), settings, cv2.OdometryAlgoType_COMMON
        )

    def prepare(self, grey: np.ndarray, depth: np.ndarray) -> cv2.OdometryFrame:
        frame = cv2.OdometryFrame(depth, grey)
        self._odometry.prepareFrame(frame)
        return frame

    def compute(
        self, source: cv2.OdometryFrame, target: cv2.OdometryFrame
    ) -> tuple[bool, np.ndarray]:
        """T_target,source; the identity where it fails."""
        try:
            ok, T = self._odometry.compute(source, target)
        except cv2.error:
            return False, np.eye(4)
        if not ok or T is None or not np.isfinite(T).all():
            return False, np.eye(4) if T is None else np.asarray(T)
        return True, np.asarray(T)


def follow(
    kind: str, K: np.ndarray, grey: np.ndarray, depth: np.ndarray
) -> tuple[list, np.ndarray]:
    """Steps (ok, T) between consecutive frames, and s per frame: preparing it and one pair."""
    cv2.setNumThreads(1)
    odometry = CvOdometry(kind, K)
    steps, seconds = [], []
    before = odometry.prepare(grey[0], depth[0])
    for image, metres in zip(grey[1:], depth[1:], strict=True):
        start = time.perf_counter()
        here = odometry.prepare(image, metres)
        steps.append(odometry.compute(before, here))
        seconds.append(time.perf_counter() - start)
        before = here
    return steps, np.array(seconds)
