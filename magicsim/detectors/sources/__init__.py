"""Where frames come from: images, folders and videos, refused before they are decoded where they are broken."""
