"""Published results, run again through the firmware."""
