"""A frame shown on the screen: by Tk, or where there is no screen, in a page on 127.0.0.1 alone."""

import base64
import contextlib
import sys
import threading
from html import escape
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import cv2

from magicsim.arrays import Frame

PAGE = (
    "<!doctype html><html lang='en'><meta charset='utf-8'><meta http-equiv='refresh' content='1'><title>{title}</title>"
    "<img alt='last frame' style='image-rendering:pixelated;height:90vh' src='data:image/png;base64,{data}'></html>"
)


class Picture:
    """One picture that changes."""

    def __init__(self, title: str) -> None:
        """Opens a window, or says on stderr where the page is."""
        self.is_open = True
        """Whether it was not closed, by its user or by `close`."""
        self._page: _Page | None = None
        try:
            import tkinter

            self._root: Any = tkinter.Tk()
        except Exception:  # tkinter is missing, or TclError: no screen
            self._page = _Page(title)
            return
        self._root.title(title)
        self._label = tkinter.Label(self._root)
        self._label.pack()
        self._root.bind("<Escape>", lambda _: self._end())
        self._root.protocol("WM_DELETE_WINDOW", self._end)

    @property
    def address(self) -> str | None:
        """Address of the page; None where there is a window."""
        return self._page.address if self._page is not None else None

    def show(self, image: Frame) -> None:
        """Shows an RGB image, shape (rows, columns, 3)."""
        if not self.is_open:
            return
        encoded = base64.b64encode(cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())
        if self._page is not None:
            self._page.data = encoded
            return
        import tkinter

        with contextlib.suppress(tkinter.TclError):  # the user has closed the window
            self._photo = tkinter.PhotoImage(data=encoded, master=self._root)
            self._label.configure(image=self._photo)
            self._root.update()

    def _end(self) -> None:
        self.is_open = False

    def close(self) -> None:
        """Closes window or page; may be called again."""
        self.is_open = False
        if self._page is not None:
            self._page.close()
            return
        import tkinter

        with contextlib.suppress(tkinter.TclError):
            self._root.destroy()


class _Page:
    """A page on 127.0.0.1 that shows the image whose PNG is `data`, in base64."""

    def __init__(self, title: str) -> None:
        self.data = b""
        page = self

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                self.send_response(200)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Cache-Control", "no-store")
                self.end_headers()
                self.wfile.write(PAGE.format(title=escape(title), data=page.data.decode()).encode())

            def log_message(self, format: str, *arguments: object) -> None:
                del format, arguments

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = f"http://127.0.0.1:{self._server.server_port}"
        threading.Thread(target=self._server.serve_forever, name="magicsim-picture", daemon=True).start()
        sys.stderr.write(f"magicsim: no screen; {title} is shown at {self.address}\n")

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()
