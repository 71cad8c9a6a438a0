"""Study and catalogue in, judged `Trial`s out: the steps that every search is made of."""
