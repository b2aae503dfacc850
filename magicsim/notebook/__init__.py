"""How results show themselves in a notebook: small tables, curves and pictures that need nothing but the page."""
