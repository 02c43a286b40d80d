"""What torque a motion needs: rigid body, friction and every further effect."""
