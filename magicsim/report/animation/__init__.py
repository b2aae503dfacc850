"""The animated preview of a stream."""
