"""What the renderer's ideal pinhole has to see, and how the camera's lens turns that into the image.

The lens moves the optical axis, distorts (OpenCV's model) and darkens towards the corners. An ideal image a little
larger than the camera's is rendered, where asked for in larger pixels, and each pixel of the camera looks up its place
there. Without any of that the ideal image is the camera's, and nothing is looked up. Lens and pixels then spread the
light of a point over the pixels around it, and dust on the window takes some.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.fft import dctn, idctn
from scipy.ndimage import gaussian_filter

from magicsim.arrays import Array, FloatImage
from magicsim.camera.camera import Camera, Lens, Window
from magicsim.camera.disturbances import transmittance
from magicsim.camera.effect_settings import Diffraction, Glare
from magicsim.camera.projection import focal_px, pixel_slopes, principal_px
from magicsim.geometry.design import ElastomerDesign

SPREAD = 3.0
"""Reach of the point spread function in standard deviations."""
BORDER_PX = 2
"""Ideal pixels beyond the outermost place that is looked up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Film:
    """The ideal image, and where the camera's pixels lie in it."""

    columns: int
    rows: int
    window: Window
    """Part of the ideal image that is looked at."""
    fov_deg: float
    """Full field of view along the ideal image's columns [degrees]."""
    places_px: FloatImage | None
    """Column and row in that window of each pixel that is read out, shape (rows, columns, 2); None where the same."""
    camera: Camera
    """Has the point spread, diffraction and glare."""
    inner: Window
    """What is read out of the pixels that were looked up: those around it spread light into it."""
    shading: FloatImage | None
    """Part of the light that each pixel that is read out gets past lens and dust, shape (rows, columns, 1); None where
    1."""

    def seen(self, ideal: FloatImage) -> FloatImage:
        """What the camera reads out, from the window of the ideal image; linear radiance, shape (rows, columns, 3)."""
        image = ideal
        if self.places_px is not None:
            image = np.asarray(
                cv2.remap(ideal, self.places_px[..., 0], self.places_px[..., 1], cv2.INTER_LINEAR), np.float32
            )
        image = spread_light(point_spread(image, self.camera.blur_px), self.camera.diffraction, self.camera.glare)
        image = np.asarray(self.inner.of(image))
        return image if self.shading is None else image * self.shading


def point_spread(image: FloatImage, blur_px: float) -> FloatImage:
    """An image blurred by a Gaussian, the core of most lenses' point spread; beyond the border its mirror goes on."""
    if blur_px == 0:
        return image
    return np.asarray(
        gaussian_filter(image, blur_px, mode="mirror", radius=_spread_px(blur_px), axes=(0, 1)), np.float32
    )


def _spread_px(blur_px: float) -> int:
    return int(np.ceil(SPREAD * blur_px))


def film(design: ElastomerDesign, lens: Lens, camera: Camera, read: Window | None = None) -> Film:
    """The ideal image for a camera."""
    shading = _shading(camera) if camera.vignetting > 0 or camera.dust is not None else None
    focal = focal_px(design, lens, camera)
    read_out = read or camera.window
    read = read_out.grown(_spread_px(camera.blur_px), camera.columns, camera.rows)
    columns, rows, places, window = camera.columns, camera.rows, None, read
    if any(camera.distortion) or any(camera.principal_offset_px) or camera.rendered_px > 1:
        slopes, focal = pixel_slopes(camera, focal), focal / camera.rendered_px
        reach = np.ceil(focal * np.abs(slopes).max((0, 1))).astype(int) + BORDER_PX
        columns, rows = (2 * int(half) for half in reach)
        places = read.of(focal * slopes + (np.array([columns, rows]) - 1) / 2)
        first = np.floor(places.min((0, 1))).astype(int) - BORDER_PX
        last = np.ceil(places.max((0, 1))).astype(int) + BORDER_PX
        first, last = np.maximum(first, 0), np.minimum(last, [columns - 1, rows - 1])
        left, top, right, bottom = (int(edge) for edge in (*first, *last))
        window = Window(column=left, row=top, columns=right - left + 1, rows=bottom - top + 1)
        places = np.asarray(places - first, np.float32)
    return Film(
        columns=columns, rows=rows, window=window, fov_deg=float(np.degrees(2 * np.arctan(columns / 2 / focal))),
        places_px=places, camera=camera, inner=read_out.within(read),
        shading=read_out.of(shading) if shading is not None else None,
    )  # fmt: skip


def _shading(camera: Camera) -> FloatImage:
    column, row = np.meshgrid(np.arange(camera.columns), np.arange(camera.rows))
    squared = ((np.stack([column, row], -1) - principal_px(camera)) ** 2).sum(-1)
    corner = (camera.columns**2 + camera.rows**2) / 4
    passed = np.clip(1 - camera.vignetting * squared / corner, 0, 1)
    if camera.dust is not None:
        passed = passed * transmittance(
            camera.dust, rows=camera.rows, columns=camera.columns, pattern_seed=camera.pattern_seed
        )
    return np.asarray(passed, np.float32)[:, :, None]


def spread_light(image: FloatImage, diffraction: Diffraction | None, glare: Glare | None) -> FloatImage:
    """The image as diffraction and glare spread it, shape (rows, columns, 3).

    Applied to the cosine transform of the image, whose mirror goes on beyond the border: all light stays in the image,
    and what is sharper than pixels can show rings about its mean. A Gaussian of deviation s transfers of a wave of
    frequency v exp(-2 pi^2 s^2 v^2).
    """
    if diffraction is None and glare is None:
        return image
    frequency = frequencies(image.shape[0], image.shape[1])
    transfer = np.ones((*frequency.shape, 3))
    if diffraction is not None:
        waves = np.array(diffraction.wavelengths_nm)
        transfer *= aperture_transfer(
            frequency[..., None] * waves * diffraction.f_number / (1e3 * diffraction.pixel_um)
        )
    if glare is not None:
        veil = np.exp(-2 * (np.pi * glare.radius_px * frequency) ** 2)
        transfer *= (1 - glare.share + glare.share * veil)[..., None]
    waves = dctn(np.asarray(image, np.float64), axes=(0, 1))
    return np.asarray(idctn(waves * transfer, axes=(0, 1)), np.float32)


def blurred_px(camera: Camera) -> float:
    """Standard deviation of the Gaussian that blur and diffraction together are nearest to [px].

    An aperture's is 0.42 wavelengths times its f-number (Zhang, Zerubia and Olivo-Marin, *Appl. Opt.* 46, 1819, 2007).
    """
    if (diffraction := camera.diffraction) is None:
        return camera.blur_px
    spot_um = 0.42e-3 * float(np.mean(diffraction.wavelengths_nm)) * diffraction.f_number
    return float(np.hypot(camera.blur_px, spot_um / diffraction.pixel_um))


def frequencies(rows: int, columns: int) -> Array:
    """Spatial frequency of each wave of the cosine transform, shape (rows, columns) [cycles/px]."""
    down, across = np.arange(rows) / (2 * rows), np.arange(columns) / (2 * columns)
    return np.asarray(np.hypot(down[:, None], across))


def aperture_transfer(relative: Array) -> Array:
    """Transfer of a circular aperture without aberration; frequencies are in units of the limit's.

    (2 / pi) (acos(u) - u sqrt(1 - u^2)) (Goodman, *Introduction to Fourier Optics*, section 6.3).
    """
    inside = np.clip(relative, 0, 1)
    return np.asarray(2 / np.pi * (np.arccos(inside) - inside * np.sqrt(1 - inside**2)))
