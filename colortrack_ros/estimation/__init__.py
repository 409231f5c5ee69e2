"""estimation: what every tracker stands on: motion models and the bank of Kalman filters."""
