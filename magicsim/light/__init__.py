"""Light in the sensor: one estimator of radiance, and the untouched sensor that every frame is anchored to."""
