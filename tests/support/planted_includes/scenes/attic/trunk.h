// A planted fault for the include test: a sub-folder without a floor.
