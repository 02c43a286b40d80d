"""Physically feasible least squares: link inertias that some distribution of mass can have.

The unknowns are the standard parameters of all links and the effects' parameters; the data
enter through their triangular factor; every link's 4 x 4 pseudo-inertia stays positive definite
(Wensing, Kim and Slotine 2018, "Linear matrix inequalities for physically consistent inertial
parameter identification"; Sousa and Cortesao 2014, "Physical feasibility of robot base inertial
parameter identification: a linear matrix inequality approach").
"""
