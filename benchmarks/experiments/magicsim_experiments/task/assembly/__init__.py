"""Assembly: two fingers plug a held plug into a base, many times, and it is counted who notices misalignment."""
