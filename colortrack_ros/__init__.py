"""Detect and track coloured objects in pictures: picture -> detections -> tracks."""
