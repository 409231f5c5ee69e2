"""Balls lit from above, one by one or of all hues in one picture."""

import colorsys

import cv2
import numpy as np


def draw_lit_ball(image, u, v, radius, rgb, least=0.5):
    """Draw a ball, in place: least of its light at the bottom."""
    y, x = np.mgrid[: image.shape[0], : image.shape[1]]
    shade = least + (1 - least) * np.clip((v + radius - y) / (2 * radius), 0, 1)
    inside = np.hypot(x - u, y - v) < radius
    image[inside] = (shade[..., None] * np.array(rgb[::-1]))[inside]


def hues(count):
    """Colors of evenly spaced hues, (count, 3) r, g, b."""
    return 255 * np.array([colorsys.hsv_to_rgb(k / count, 0.75, 0.9) for k in range(count)])


def wheel(colors, least, noise=3.0):
    """A picture of balls of radius 28, of these colors, and their places."""
    image = np.full((300, 400, 3), 240.0)
    places = [(45 + 95 * (k % 4), 35 + 70 * (k // 4)) for k in range(len(colors))]
    for (u, v), rgb in zip(places, colors, strict=True):
        draw_lit_ball(image, u, v, 28, rgb, least)
    image = cv2.GaussianBlur(image, (0, 0), 0.7)
    image += np.random.default_rng(0).normal(0, noise, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8), places
