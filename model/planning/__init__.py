"""Device in, locking plan out: order, postures, torques, what stays unidentifiable."""
