"""Table 3.1 of Léveillé 2013: the verification trials, run and compared, and the helicopter identified from them."""
