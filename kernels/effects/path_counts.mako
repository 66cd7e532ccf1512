// The path table: an arrival into the cell of its path.  The detector ends the sequence, so that all
// detectors share a table; what is known of a key is the detector and the number of interactions.
// reads: the record's key, ray and generation.  writes: the batch's cells by key.
FN void count_path(keyed_t *keyed, __global const long *codes, const launch_t *launch, long which,
                   const ending_record_t *end) {
    if (!codes[launch->path_tables + which]) return;
    const ulong trail = (ulong)end->trail_hi << 32 | end->trail_lo;
    const ulong ray = (ulong)end->ray_hi << 32 | end->ray_lo;
    count_keyed(keyed, path_key(trail, (ulong)which), (ulong)which << 32 | end->generation, ray, end->w);
}
