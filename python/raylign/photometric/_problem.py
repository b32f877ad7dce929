"""What a photometric bundle adjustment is about: images, cameras, points, and what is known."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from raylign import _core, io
from raylign._core import PatchPattern
from raylign._typing import F32, F64, U8, AnyArray, PathLike
from raylign.camera import PinholeCamera
from raylign.depth import DepthModel
from raylign.errors import ShapeError
from raylign.image import ColorOrder
from raylign.photometric._from_depth import select_points
from raylign.photometric._images import (
    as_f64,
    cameras_of,
    check_principal_points,
    load_pixels,
    prepare,
)
from raylign.photometric._inputs import (
    corrections_of,
    covariances_of,
    hosts_of,
    image_list,
    optional,
    patches_by_column,
    poses_of,
    tracks_of,
)

_MAX_LEVELS = 6
_DEFAULT_PATTERN = 16  # pixels, when there is no patch to count them


class Problem:
    """Images, cameras and points to be refined from grey values.

    Args:
        images: M of them: (H, W) or (H, W, 3) arrays of uint8, uint16 or float32 grey 0..255, or
            paths; sizes may differ.
        K: intrinsics of all images or one each: (3, 3), (fx, fy, cx, cy), a PinholeCamera or a
            RadtanCamera, or M of them.
        T_cw: (M, 4, 4), or (M, 7) `tx ty tz qx qy qz qw`.
        points: (N, 3) world frame, scene units.
        convention: "cw": poses map the world to the camera; "wc": the other way.
        patches: (N, n) grey values that the images are compared with. Default: read from `host`.
        pattern: of the patches, whose n is checked here. Default: the one in `PhotometricOptions`,
            which may be of any shape, so that `adjust` is the first to know whether n is right.
        patch_order: of the numbers of a square patch: "column": u outermost, as the files of the
            original exercise; "row": v outermost, as `image[v, u].ravel()`.
        host: (N,) index of the image a point's patch is read from, −1 where `patches` has it; or
            "auto", the default without patches: the view that sees the point best.
        host_uv: (N, 2) px of the host image (undistorted), NaN where unknown. Default: where the
            point projects to.
        normals: (N, 3) of the surface in the host's frame, NaN where unknown.
        masks: per image (H, W) bool or integer, or None; where 0, a pixel does not count.
        tracks: which images see a point: (M, N) bool, or (K, 2) pairs (image, point). Default: it
            is found out.
        brightness: (M, 2) start of a, b. Default: estimated.
        exposure: (M,) exposure times, any unit, > 0.
        response: (256,) irradiance, grey 0..255, of each raw grey value; increasing.
        vignette: (H, W) share of light that arrives, or one array per image.
        saturation: raw grey values outside of these do not count once response, vignette or
            exposure have changed them; without those, VisibilityOptions.min_grey and max_grey rule.
        distortion: k1 k2 p1 p2 [k3], for all or per image: images are undistorted to K.
        pose_covariance: (M, 6, 6) of ξ, T_cw = exp(ξ) T_start, or (6, 6) for all; NaN: none.
        point_covariance: (N, 3, 3) of the points, or (3, 3) for all; NaN: none.
        depth_sigma: (N,) standard deviation of z in the host's frame, scene units; NaN: none.
        color_order: of the channels of colour images.

    Raises:
        ShapeError: an array has another shape or dtype, or holds a number that is not finite; a
            T_cw is no rigid motion, a rotation is left-handed. The message names row and value.
        OptionsError: a camera is out of range, or belongs to images of another size.
        FormatError: an image file cannot be read.

    Example:
        >>> import raylign
        >>> scene = raylign.synthetic.room(seed=1)
        >>> camera = raylign.camera.PinholeCamera(120.0, 120.0, 79.5, 59.5)
        >>> T_cw = raylign.geometry.se3_exp([[0.1 * i, 0, 0, 0, 0, 0] for i in range(3)])
        >>> views = [
        ...     raylign.synthetic.render(scene, camera, T, width=160, height=120) for T in T_cw
        ... ]
        >>> points = [[0.0, 0.1, 1.5], [0.2, -0.1, 1.6]]
        >>> Problem([view.image for view in views], camera, T_cw, points)
        <Problem: 3 images, 2 points, patches from their hosts>
    """

    def __init__(
        self,
        images: Sequence[AnyArray | PathLike],
        K: Any,
        T_cw: npt.ArrayLike,
        points: npt.ArrayLike,
        *,
        convention: str = "cw",
        patches: npt.ArrayLike | None = None,
        pattern: PatchPattern | str | None = None,
        patch_order: str = "column",
        host: npt.ArrayLike | str | None = None,
        host_uv: npt.ArrayLike | None = None,
        normals: npt.ArrayLike | None = None,
        masks: Sequence[AnyArray | None] | None = None,
        tracks: npt.ArrayLike | None = None,
        brightness: npt.ArrayLike | None = None,
        exposure: npt.ArrayLike | None = None,
        response: npt.ArrayLike | None = None,
        vignette: AnyArray | Sequence[AnyArray] | None = None,
        saturation: tuple[float, float] = (3.0, 250.0),
        distortion: npt.ArrayLike | None = None,
        pose_covariance: npt.ArrayLike | None = None,
        point_covariance: npt.ArrayLike | None = None,
        depth_sigma: npt.ArrayLike | None = None,
        color_order: ColorOrder = ColorOrder.RGB,
    ) -> None:
        sources = image_list(images)
        num = len(sources)
        poses = poses_of(T_cw, convention)
        if len(poses) != num:
            raise ShapeError(f"there are {num} images but {len(poses)} poses")
        if masks is not None and len(masks) != num:
            raise ShapeError(f"there are {num} images but {len(masks)} masks")
        corrections = corrections_of(response, vignette, exposure, saturation, num)
        cameras = cameras_of(K, distortion, num)
        prepared = prepare(
            sources, cameras, masks=masks, corrections=corrections, color_order=color_order
        )
        check_principal_points(prepared.cameras, prepared.grey)
        self._colors = prepared.colors
        self._is_corrected = corrections.active
        self._timestamps: F64 | None = None
        xyz = as_f64(points, "points", (None, 3))
        size = len(xyz)
        arrays: dict[str, AnyArray | None] = {
            "T_cw": poses,
            "points": xyz,
            "intrinsics": np.array([c.params for c in prepared.cameras]),
            "patches": patches_by_column(patches, size, patch_order, pattern),
            "hosts": hosts_of(host, size, patches is not None),
            "host_uv": optional(host_uv, "host_uv", (size, 2)),
            "normals": optional(normals, "normals", (size, 3)),
            "brightness": optional(brightness, "brightness", (num, 2)),
            "pose_covariances": covariances_of(pose_covariance, "pose_covariance", num, 6),
            "point_covariances": covariances_of(point_covariance, "point_covariance", size, 3),
            "depth_sigmas": optional(depth_sigma, "depth_sigma", (size,)),
        }
        arrays["track_image"], arrays["track_point"] = tracks_of(tracks, num, size)
        self._arrays = arrays
        some_mask = any(mask is not None for mask in prepared.masks)
        self._core = _core.PhotometricProblem(
            images=prepared.grey,
            masks=prepared.masks if some_mask else [],
            max_levels=_MAX_LEVELS,
            arrays=arrays,
        )
        self._core.validate(pattern_size=self.patch_size or _DEFAULT_PATTERN)

    @classmethod
    def from_text(
        cls,
        points: PathLike,
        poses: PathLike,
        images: PathLike | Iterable[PathLike],
        K: Any,
        *,
        num_values: int | None = None,
        **options: Any,
    ) -> "Problem":
        """Read the files of the original exercise.

        Args:
            points: `x y z g0 g1 …` per line (`io.read_patch_points`).
            poses: `timestamp tx ty tz qx qy qz qw` per line, T_cw (`io.read_poses`).
            images: folder, pattern or list, one image per pose in order (`io.list_images`).
            K: as the constructor.
            num_values: grey values per point; default: as the file has. Without any, patches are
                read from the images.
            **options: of the constructor; `patch_order` is "column" unless said.

        Raises:
            FormatError: a file is missing or damaged, there are not as many images as poses; the
                message has file, line and numbers.
        """
        xyz, patches = io.read_patch_points(points, num_values=num_values)
        timestamps, T_cw = io.read_poses(poses)
        paths = io.list_images(images, count=len(T_cw))
        problem = cls(paths, K, T_cw, xyz, patches=patches if patches.shape[1] else None, **options)
        problem._timestamps = timestamps
        return problem

    @classmethod
    def from_depth(
        cls,
        images: Sequence[AnyArray | PathLike],
        depths: Sequence[AnyArray],
        K: Any,
        T_cw: npt.ArrayLike,
        n_points: int = 2000,
        *,
        depth_scale: float = 1000.0,
        depth_model: DepthModel | None = None,
        convention: str = "cw",
        color_order: ColorOrder = ColorOrder.RGB,
        **options: Any,
    ) -> "Problem":
        """Choose points from images with depth: each has its patch, normal and depth from its host.

        Points are local maxima of the gradient, spread over a grid that is refined where texture is
        rich, at valid depth away from depth edges; every image hosts its share.

        Args:
            images: as the constructor.
            depths: (H, W) per image, float m along the optical axis or uint16 in 1/depth_scale m; 0
                and NaN: none. Rectified like the images: K has no distortion.
            K: as the constructor.
            T_cw: as the constructor.
            n_points: about how many points in all, >= 1.
            depth_scale: units per m of uint16 depth.
            depth_model: noise of the depth, which becomes the prior `depth_sigma` and fixes the
                scale. Default: no prior, depth is only the start.
            convention: of T_cw.
            color_order: of the channels of colour images.
            **options: of the constructor.

        Raises:
            ShapeError: there are not as many depths as images, or their sizes differ.
            OptionsError: no image has texture where it has depth.
        """
        sources = [load_pixels(image, i) for i, image in enumerate(image_list(images))]
        poses = poses_of(T_cw, convention)
        if not len(poses) == len(depths) == len(sources):
            raise ShapeError(
                f"there are {len(sources)} images, {len(depths)} depths and {len(poses)} poses"
            )
        cameras = cameras_of(K, None, len(sources))
        chosen = select_points(
            sources,
            depths,
            cameras,
            poses,
            n_points=n_points,
            depth_scale=depth_scale,
            model=depth_model,
            color_order=color_order,
        )
        return cls(
            sources,
            K,
            poses,
            chosen.points,
            host=chosen.host,
            host_uv=chosen.host_uv,
            normals=chosen.normals,
            depth_sigma=chosen.depth_sigma,
            color_order=color_order,
            **options,
        )

    def __repr__(self) -> str:
        what = f"stored patches of {self.patch_size}" if self.patch_size else "from their hosts"
        text = what if self.patch_size else f"patches {what}"
        return f"<Problem: {self.num_images} images, {self.num_points} points, {text}>"

    @property
    def num_images(self) -> int:
        """M."""
        return len(self.T_cw)

    @property
    def num_points(self) -> int:
        """N."""
        return len(self.points)

    @property
    def patch_size(self) -> int:
        """Pixels of a stored patch; 0 where patches are read from the images."""
        patches = self._arrays["patches"]
        return 0 if patches is None else int(patches.shape[1])

    @property
    def T_cw(self) -> F64:
        """(M, 4, 4) start; read-only in effect: a copy of what a solve sees."""
        return np.array(self._arrays["T_cw"])

    @property
    def points(self) -> F64:
        """(N, 3) start, world frame."""
        return np.array(self._arrays["points"])

    @property
    def intrinsics(self) -> F64:
        """(1, 4) of all images or (M, 4): fx, fy, cx, cy of the undistorted images."""
        return np.array(self._arrays["intrinsics"])

    @property
    def patches(self) -> F32 | None:
        """(N, n) stored patches by columns, or None."""
        patches = self._arrays["patches"]
        return None if patches is None else np.array(patches)

    @property
    def timestamps(self) -> F64 | None:
        """(M,) s, of `from_text`."""
        return self._timestamps

    @property
    def is_corrected(self) -> bool:
        """Response, vignette or exposure were applied: masks stand for the saturation limits."""
        return self._is_corrected

    @property
    def has_depth_prior(self) -> bool:
        """A depth is known to some standard deviation, which fixes the scale."""
        return self._arrays["depth_sigmas"] is not None

    def camera(self, i: int) -> PinholeCamera:
        """Camera of image i, undistorted."""
        rows = self._arrays["intrinsics"]
        assert rows is not None
        return PinholeCamera(*rows[i if len(rows) > 1 else 0].tolist())

    def image(self, i: int) -> F32:
        """(H, W) float32 grey of image i as it is compared: corrected, undistorted; read-only."""
        return self._core.image(i)

    def color_image(self, i: int) -> U8 | None:
        """(H, W, 3) RGB of image i, undistorted, or None for a grey one."""
        return self._colors[i]

    def project(
        self, i: int, *, T_cw: F64 | None = None, points: F64 | None = None
    ) -> tuple[F64, F64]:
        """Where points appear in image i.

        Args:
            i: image.
            T_cw: (M, 4, 4); default: the start.
            points: (N, 3); default: the start.

        Returns:
            (N, 2) px, NaN behind the camera, and (N,) depth z in scene units.
        """
        T = (self.T_cw if T_cw is None else T_cw)[i]
        p_c = (self.points if points is None else points) @ T[:3, :3].T + T[:3, 3]
        uv, valid = self.camera(i).project(p_c)
        uv[~valid] = np.nan
        return uv, p_c[:, 2]
