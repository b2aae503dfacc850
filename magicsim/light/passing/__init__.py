"""What passes in the room: the change that it makes of the room's light, added to frames of the still room."""
