// Of a planted fault for the language test.
