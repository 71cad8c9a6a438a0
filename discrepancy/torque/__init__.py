"""The same for runs under position control: `TorqueStudy`, its fits, drive and floor; torque is the residual."""
