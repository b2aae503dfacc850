"""A frame shown on the screen: by Tk, or where there is no screen, in a page on 127.0.0.1 alone."""

import base64
import contextlib
import sys
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any, ClassVar

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
        self._root, self._label, self._photo = _tk_window(title)
        self._page = None if self._root is not None else _Page(title)
        self.is_open = True
        """Whether it was not closed, by its user or by `close`."""
        if self._root is not None:
            self._root.bind("<Escape>", lambda _: self._end())
            self._root.protocol("WM_DELETE_WINDOW", self._end)

    @property
    def address(self) -> str | None:
        """Address of the page; None where there is a window."""
        return self._page.address if self._page is not None else None

    def show(self, image: Frame) -> None:
        """Shows an RGB image, shape (rows, columns, 3)."""
        encoded = base64.b64encode(cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes())
        if not self.is_open:
            return
        if self._page is not None:
            self._page.put(encoded)
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


def _tk_window(title: str) -> tuple[Any, Any, Any]:
    """Window and label of Tk, and no image yet; None where Tk or the screen is missing."""
    try:
        import tkinter

        root = tkinter.Tk()
    except Exception:  # tkinter is missing, or TclError: no screen
        return None, None, None
    root.title(title)
    label = tkinter.Label(root)
    label.pack()
    return root, label, None


class _Page:
    def __init__(self, title: str) -> None:
        page = self
        self._title, self._data = title, b""

        class Handler(BaseHTTPRequestHandler):
            headers_out: ClassVar = {"Content-Type": "text/html; charset=utf-8", "Cache-Control": "no-store"}

            def do_GET(self) -> None:
                body = PAGE.format(title=page._title, data=page._data.decode()).encode()
                self.send_response(200)
                for name, value in self.headers_out.items():
                    self.send_header(name, value)
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, format: str, *arguments: object) -> None:
                del format, arguments

        self._server = ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = f"http://127.0.0.1:{self._server.server_port}"
        threading.Thread(target=self._server.serve_forever, name="magicsim-picture", daemon=True).start()
        sys.stderr.write(f"magicsim: no screen; {title} is shown at {self.address}\n")

    def put(self, encoded: bytes) -> None:
        self._data = encoded

    def close(self) -> None:
        self._server.shutdown()
        self._server.server_close()
