"""Identifiers of the shapes in the Mitsuba scene, and of the light from all around."""

BODY = "body"
INFILL = "infill"
OBJECT = "object"
GHOST = "ghost"
FLASHLIGHT = "flashlight"
ENVIRONMENT = "environment"
HOUSING = "housing"
