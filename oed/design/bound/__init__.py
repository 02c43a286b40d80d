"""Upper bounds on the information of any trajectory, by convex relaxation over visited states.

Lambda is linear in the measure mu of the states (q, dq, ddq) that a motion visits. Whatever its
parametrisation, a motion within the limits visits admissible states only, and a periodic one
returns every smooth function phi(q, dq) to its start, so that the mean of d phi / dt over mu is
zero. The largest log det Lambda over all such measures bounds every such motion
(Lasserre, Henrion, Prieur and Trelat 2008, "Nonlinear optimal control via occupation measures",
with Kiefer and Wolfowitz 1960 for the criterion).
"""
