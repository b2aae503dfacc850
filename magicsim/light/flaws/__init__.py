"""What a print has that its drawing has not, as light meets it: rough interfaces, bubbles, flakes."""
