"""What several test files use: readers, references, random cases, and how cases are swept."""
