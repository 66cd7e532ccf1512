## effects, classes, launch_struct (text of the typedef), item_struct, queue fields
// The ray packet, the surface hit, and what one launch is told.

${launch_struct}
${item_struct}

// Packets that a work-item keeps; more than one where they are taken in turn (effects/acceleration.mako).
#define PACKETS ${packets}

// A ray in every lane.  Weights are relative to the heaviest launched ray of the scene.
// left: the face this ray left, as code << 2 | (now on the + side) << 1 | (came from the + side),
// or NO_FACE for a launched ray.  The + side of a face is the one its outward normal points to.
// note: the faces within rounding of where it started last, with the side of each that it was on
// (faces.mako).  came: the last segment that had a length.
typedef struct {
    real ox, oy, oz, dx, dy, dz, w;
    lint left;
% if "contact" in effects:
    lint ${", ".join(f"note{n}" for n in range(note_words))};
    real came_x, came_y, came_z;
% endif
    word ray_lo, ray_hi, generation;
% if "splitting" in effects:
    luint path;
% endif
% if "shares" in effects and "roulette" in effects:
    real launched;
% endif
    mask alive;
} packet_t;

// What the kernels read of the compiled scene.
typedef struct {
    __global const double *geometry;    // a row per element, in file order
    __global const double *materials;   // a row per distinct surface
    __global const double *sources;     // a row per source
    __global const long *codes;         // see "The table of codes", and launch_t
} scene_t;

% if "contact" in effects:
// Faces and the side of each that a ray is on (faces.mako).
typedef struct { lint ${", ".join(f"word{n}" for n in range(note_words))}; } notes_t;

% endif
// code: element number << 32 | face << 16 | has a detector << 12 | surface kind << 8 | normal points
// down its axis << 7 | element class.  plane: the coordinate of a flat face across an axis.  edge: it
// was met within rounding of its edge.  noted: the faces within rounding of the ray's start, which it
// will remember.
typedef struct {
    real t;
    lint code;
    mask found;
    real plane;
    mask edge;
% if "contact" in effects:
    notes_t noted;
% endif
} hit_t;

typedef struct {
    real x, y, z, nx, ny, nz;
    mask came_plus;
    mask inner;       // a detector counts it as on the - side, wherever it came from
    mask from_minus;  // came from the - side whatever the rounding of d.n says
} contact_t;

// Columns of an element's row in the geometry table.
#define ROW ${row_stride}
#define ROW_FRAME ${row_frame}
#define ELEMENT_OF(code) ((code) >> 32)
#define FACE_OF(code) (((code) >> 16) & 0xFFFFL)
#define WITHOUT_FACE(code) ((code) & ~0xFFFF0000L)
#define WITH_FACE(code, face) ((code) | ((face) << 16))
#define HAS_DETECTOR(code) NE((code) & (1L << 12), lsplat(0L))
#define SURFACE_OF(code) (((code) >> 8) & 15L)
#define AXIS_SIGN(code) SEL(NE((code) & 128L, lsplat(0L)), splat(-1.0), splat(1.0))
#define CLASS_OF(code) ((code) & 127L)

// The table of codes.  It begins with where each class's first code stands; then, without a tree,
// where the last end, and the codes by class.  With a tree where that stands in the geometry table,
// and in file order the codes with the material's row in place of the element's number.
% if "acceleration" in effects:
#define TREE_PLACE(scene) ((scene)->codes[${len(classes)}])
#define CODE_ENTRY(scene, element) ((scene)->codes[${len(classes) + 1} + (element)])
#define CODE_AT(scene, element) (CODE_ENTRY(scene, element) & 0xFFFFFFFFL | (long)(element) << 32)
#define ONLY_ELEMENT(scene, number) ((scene)->codes[number] - ${len(classes) + 1})
#define MATERIAL_OF(entry) ((entry) >> 32)
% else:
#define ONLY_ELEMENT(scene, number) ELEMENT_OF((scene)->codes[(scene)->codes[number]])
#define MATERIAL_OF(entry) (entry)
% endif

FN luint path_of(const packet_t *p) {
% if "splitting" in effects:
    return p->path;
% else:
    return (luint)(1UL);
% endif
}

// One search for the nearest face: whether this is the careful pass, which lanes need one, and what
// it notes for the next search.
typedef struct {
    int careful;
    mask doubtful;
% if "contact" in effects:
    notes_t noted;
% endif
} search_t;

// In faces.mako; the elements' functions call them.
% if "contact" in effects:
FN mask starts_on(search_t *search, const packet_t *p, mask beside, long code, mask on, real height, real near,
                  real nx, real ny, real nz, real d_n, mask *minus, mask *crosses);
FN mask known_side(const notes_t *notes, mask m, lint code, mask *on_minus);
% else:
FN mask crosses(const packet_t *p, mask m, real h_d);
% endif
