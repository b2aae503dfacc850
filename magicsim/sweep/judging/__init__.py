"""What a design is judged by: each part films or presses it and gives measures."""
