"""What the generated C costs and how far it errs, beside lookup tables, float C and other people's libraries."""
