"""What a torque model still lacks: residual, lack of fit, candidates, selection, verdict."""
