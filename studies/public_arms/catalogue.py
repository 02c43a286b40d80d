"""The public recordings that are read, in the order of the table."""

from studies.public_arms import (
    med7_london,
    panda_rome,
    panda_salerno,
    pendulum_dfki,
    psm_worcester,
    tiago_toulouse,
    tx40_nantes,
    ur10_salerno,
)

ARMS = {
    module.ARM.name: module.ARM
    for module in (
        ur10_salerno,
        panda_salerno,
        panda_rome,
        pendulum_dfki,
        tx40_nantes,
        tiago_toulouse,
        med7_london,
        psm_worcester,
    )
}
