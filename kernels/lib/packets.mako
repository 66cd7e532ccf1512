## effects, classes, splits, children, orders, ends; ray_struct (text of members); hit_fields; columns, strides;
## code (fields of a code); counts (of notes)
// The ray packet and the surface hit.

// Packets that a work-item keeps; more than one where they are taken in turn (effects/acceleration.mako).
#define PACKETS ${packets}

// Packets of rays that an interaction gives beside the one that goes on.
#define CHILDREN ${max(children, 1)}

// A ray in every lane.  The + side of a face is the one its outward normal points to.
typedef struct {
${ray_struct}    mask alive;
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
typedef struct { lint ${", ".join(f"word{n}" for n in range(counts["note_words"]))}; } notes_t;

% endif
typedef struct {
% for field in hit_fields:
% if "." not in field.name:
    ${{"real": "real", "long": "lint", "mask": "mask"}[field.type]} ${field.name};  // ${field.meaning}
% endif
% endfor
    mask found;
% if "contact" in effects:
    notes_t noted;  // the faces within rounding of the ray's start, which it will remember
% endif
} hit_t;

typedef struct {
    real x, y, z, nx, ny, nz;
    mask came_plus;
    mask inner;       // a detector counts it as on the - side, wherever it came from
    mask from_minus;  // came from the - side whatever the rounding of d.n says
    mask from_plus;   // came from the + side whatever it says
% if ends:
    mask lost;        // ended on its way there
% endif
} contact_t;

// A contact at a distance along a ray, before its face is asked.
FN contact_t no_contact(const packet_t *p, real t) {
    contact_t c;
    c.x = fma(t, p->dx, p->ox);
    c.y = fma(t, p->dy, p->oy);
    c.z = fma(t, p->dz, p->oz);
    c.nx = splat(0.0); c.ny = splat(0.0); c.nz = splat(0.0);
    c.came_plus = NO_LANES;
    c.from_minus = NO_LANES;
    c.from_plus = NO_LANES;
    c.inner = NO_LANES;
    return c;
}

// Whether the ray came to a contact from its face's + side.
FN mask came_from_plus(const packet_t *p, const contact_t *c) {
    return (LE(dot3(p->dx, p->dy, p->dz, c->nx, c->ny, c->nz), splat(0.0)) & ~c->from_minus) | c->from_plus;
}

// Columns of the tables' rows, as the kinds in use declare them.  An element's row begins with its
// position, and ends with its frame.
#define ROW ${strides.row}
#define ROW_FRAME ${strides.row_frame}
#define SOURCE_STRIDE ${strides.source}
#define SOURCE_FRAME ${strides.source_frame}
% for name, place in columns:
#define ${name} ${place}
% endfor

// The code of an element, and of a face of it (hostcode/program/codes.py).
#define ELEMENT_OF(code) ((code) >> ${code["element"].shift})
#define FACE_OF(code) (((code) >> ${code["face"].shift}) & ${hex(code["face"].mask)}L)
#define WITHOUT_FACE(code) ((code) & ~(${hex(code["face"].mask)}L << ${code["face"].shift}))
#define WITH_FACE(code, face) ((code) | ((face) << ${code["face"].shift}))
#define HAS_DETECTOR(code) INE((code) & (1L << ${code["detector"].shift}), lsplat(0L))
#define SURFACE_OF(code) (((code) >> ${code["surface"].shift}) & ${code["surface"].mask}L)
#define AXIS_SIGN(code) SEL(INE((code) & (1L << ${code["down"].shift}), lsplat(0L)), splat(-1.0), splat(1.0))
#define CLASS_OF(code) ((code) & ${code["cls"].mask}L)

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
% if splits:
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
% if orders:
    int settling;      // whether this pass settles which of the faces in one place comes first
    mask shared;       // lanes in which that is to be settled
    real nearest;      // distance of the nearest face in m
    real room;         // for its rounding, along the normal, in m
    real nx, ny, nz;   // its normal
    real plane;        // of the one that comes first so far
    lint code, rank;
    mask edge;
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
