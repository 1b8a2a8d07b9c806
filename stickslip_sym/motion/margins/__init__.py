"""How far an operating point is from stick-slip: critical values of one quantity, and margins of all."""
