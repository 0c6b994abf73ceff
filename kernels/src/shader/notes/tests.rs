//! Notes and assertions are found, typed, and leave every column where it is.
