"""Light that six slabs reflect and transmit, by walks, tables and closed forms."""
