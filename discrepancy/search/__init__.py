"""Study in, `SearchResult` out: forward selection, backward elimination, contenders."""
