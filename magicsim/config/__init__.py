"""Configuration: TOML files and presets become checked, frozen models; whatever is wrong is one line."""
