"""A viewer in a notebook: a page within it, and a picture until that is there, or where it cannot be."""

from __future__ import annotations

import asyncio
import base64
import io
from pathlib import Path
from typing import Any

from membrane_rs._extras import need
from membrane_rs._files import path_of
from membrane_rs.analysis.attitude import turned
from membrane_rs.errors import MissingExtraError
from membrane_rs.plotting.painter import painter, pyvista_works
from membrane_rs.plotting.picture import Image
from membrane_rs.plotting.scenery import Scenery
from membrane_rs.plotting.viewer.canvas import canvas_of
from membrane_rs.plotting.viewer.page import SIZE, Page
from membrane_rs.plotting.viewer.pictures import save_as
from membrane_rs.plotting.viewer.viewer import Viewer

PICTURE_SIZE = 700


class NotebookView:
    """What a notebook shows of a run.

    Parameters
    ----------
    viewer : Viewer
        What is shown.
    is_live : bool
        Whether a page takes the place of the picture, once its server has started in the notebook's kernel.

    Raises
    ------
    MissingExtraError
        What draws the picture is not installed.

    Examples
    --------
    >>> import membrane_rs
    >>> view = membrane_rs.run("hanging-strip", until=0.01, frames=2).view(where="picture")
    >>> view.save("strip.png").name
    'strip.png'
    """

    def __init__(self, viewer: Viewer, *, is_live: bool = True) -> None:
        need("matplotlib", "PIL", use="a view of a run")
        self.viewer, self.hint = viewer, ""
        self.page: Page | None = None
        works = pyvista_works()
        if is_live and not works:
            self.hint = "pyvista cannot draw here, for want of OpenGL; this picture is drawn by matplotlib"
        elif is_live:
            try:
                self.page = Page(viewer)
            except MissingExtraError as error:
                self.hint = f"A picture, since the page that turns and plays is missing: {error}"
        self._image = self._picture(works)
        self._start: Any = None

    def __repr__(self) -> str:
        return f"<view of {self.viewer.name} at {self.viewer.words()}, coloured by {self.viewer.color}>"

    def save(self, path: str | Path) -> Path:
        """Write the picture as a PNG file that is not there yet.

        Parameters
        ----------
        path : path
            The file.

        Returns
        -------
        Path
            The same.

        Raises
        ------
        OutputError
            It is there already, or cannot be written.
        InputError, InputTypeError
            No path.
        """
        return save_as(self._image, path_of(path))

    def _repr_html_(self) -> str:
        """The picture, and why it is one."""
        hint = f'<div style="color: #777; font-size: 90%;">{self.hint}</div>' if self.hint else ""
        return f'<img src="data:image/png;base64,{_png(self._image)}" style="max-width: 100%;"/>{hint}'

    def _ipython_display_(self) -> None:
        """Show the picture, and the page in its place once that is ready."""
        handle = _ipython().display(_ipython().HTML(self._repr_html_()), display_id=True)
        if self.page is not None:
            self._start = asyncio.ensure_future(self._replace(handle, self.page))

    async def _replace(self, handle: Any, page: Page) -> None:
        await page.start()
        handle.update(_ipython().HTML(page.html()))

    def _picture(self, works: bool) -> Image:
        if self.page is not None:
            return self.page.canvas.image()
        if works:
            return canvas_of(self.viewer, SIZE).image()
        shown = self.viewer.shown()
        with painter(self.viewer.subject, PICTURE_SIZE) as artist:
            return artist.paint(turned(shown.positions, shown.hub_angle), 0.0, Scenery(shown.solids))


def _ipython() -> Any:
    """What a notebook displays by, without types."""
    import IPython.display

    return IPython.display


def _png(image: Image) -> str:
    """A picture in base 64."""
    from PIL import Image as Pillow

    stream = io.BytesIO()
    Pillow.fromarray(image).save(stream, "PNG")
    return base64.b64encode(stream.getvalue()).decode()
