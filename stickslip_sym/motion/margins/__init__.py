"""How far a scene is from stick-slip: where one quantity puts the threshold at the given damping, and margins.

`critical` serves every quantity and parameter, `transition_speed` is its case for V, and `margins` asks for all.
"""
