"""Identifiers of the shapes in the Mitsuba scene."""

BODY = "body"
INFILL = "infill"
OBJECT = "object"
FLASHLIGHT = "flashlight"
