import base64
import io
import re

import numpy as np
from PIL import Image

from magicsim.notebook import picture_row


def test_pictures_hold_the_pixels_and_captions():
    image = np.arange(24, dtype=np.uint8).reshape(2, 4, 3)
    row = picture_row([(image, "gap < 1 mm"), (image, "touch")])
    assert row.count("<img") == 2
    assert "gap &lt; 1 mm" in row
    coded = re.search(r"base64,([^\"]+)", row)
    assert (np.asarray(Image.open(io.BytesIO(base64.b64decode(coded[1])))) == image).all()
