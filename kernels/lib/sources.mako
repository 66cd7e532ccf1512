## sources: the source kinds in use, each with .kind, .stem and .number
// Fresh rays.  Ray i of a batch belongs to the source whose range of i holds it.
//
// Row of the source table: 0-2 position, 3 radius, 4 launched weight, 5 first ray, 6 behind the
// last ray, 7 needs a position draw, 8-16 frame.
#define SOURCE_STRIDE ${source_stride}
#define SOURCE_RADIUS 3
#define SOURCE_FRAME 8
