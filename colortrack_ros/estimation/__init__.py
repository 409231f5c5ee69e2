"""estimation: what all trackers share: motion models, the bank of Kalman filters, track tables."""
