"""Output of `ods assess track`: its table and chart, figures 6 and 7 of [SSIE]."""
