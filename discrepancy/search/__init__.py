"""Study in, `Search` out: nominal model, forward selection, backward elimination, contenders."""
