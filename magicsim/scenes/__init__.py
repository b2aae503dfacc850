"""The sensor as light sees it: rig, materials, estimators of radiance, camera."""
