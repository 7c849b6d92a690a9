// A planted fault for the layout test: no test names this source.
