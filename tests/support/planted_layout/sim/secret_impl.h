// A planted fault for the layout test: a file with a forbidden name.
