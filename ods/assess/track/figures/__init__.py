"""What `ods assess track` prints and draws: its table and chart, figures 6 and 7 of [SSIE]."""
