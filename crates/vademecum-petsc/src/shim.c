/* The calls of MPI and PETSc that the crate makes. Widths of integers, numbers of enums and macros are those of
   the installed headers. Every function returns 0, or something else when it failed; then vp_failed_call and
   vp_failed_words tell what and why. Blocks are columns one after the other, without gaps. */
#include <float.h>
#include <petscksp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#if defined(PETSC_USE_COMPLEX)
#error "vademecum needs a PETSc of real numbers; this one is built for complex ones"
#endif
#if !defined(PETSC_HAVE_MUMPS)
#error "vademecum needs a PETSc with MUMPS; this one has none: install libpetsc-real-dev, or configure PETSc with --download-mumps"
#endif
_Static_assert(sizeof(PetscScalar) == sizeof(double), "vademecum needs a PETSc in double precision");

enum { TAG = 7, CHUNK = 1 << 28 };

static char failed_call[64], failed_words[512];
static int failed_short;

const char *vp_failed_call(void) { return failed_call; }
const char *vp_failed_words(void) { return failed_words; }
/* Whether memory was refused. */
int vp_failed_short(void) { return failed_short; }

static int fail(const char *call, const char *words) {
    snprintf(failed_call, sizeof failed_call, "%s", call);
    snprintf(failed_words, sizeof failed_words, "%s", words);
    failed_short = !strcmp(call, "malloc");
    return 1;
}

static int mpi(int code, const char *call) {
    if (code == MPI_SUCCESS) return 0;
    char words[MPI_MAX_ERROR_STRING + 1] = "";
    int length = 0;
    MPI_Error_string(code, words, &length);
    return fail(call, words);
}

static int petsc(PetscErrorCode code, const char *call) {
    if (!code) return 0;
    const char *general = NULL;
    char *specific = NULL, words[512];
    (void)PetscErrorMessage(code, &general, &specific);
    snprintf(words, sizeof words, "%s (error %d)%s%s", general ? general : "no words for it", (int)code,
             specific && *specific ? ": " : "", specific ? specific : "");
    (void)fail(call, words);
    failed_short = code == PETSC_ERR_MEM;
    return 1;
}

#define MPI(call, ...) do { if (mpi(call(__VA_ARGS__), #call)) return 1; } while (0)
#define PETSC(call, ...) do { if (petsc(call(__VA_ARGS__), #call)) return 1; } while (0)

/* Starts MPI and PETSc; *ranks is set to this rank, the number of ranks, and the number of those on this machine. */
int vp_start(int64_t *ranks) {
    int given = 0, rank = 0, size = 0, near = 0;
    MPI_Comm node;
    MPI(MPI_Init_thread, NULL, NULL, MPI_THREAD_SERIALIZED, &given);
    if (given < MPI_THREAD_SERIALIZED) return fail("MPI_Init_thread", "this MPI cannot be called from more than one thread");
    MPI(MPI_Comm_set_errhandler, MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI(MPI_Comm_set_errhandler, MPI_COMM_SELF, MPI_ERRORS_RETURN);
    MPI(MPI_Comm_rank, MPI_COMM_WORLD, &rank);
    MPI(MPI_Comm_size, MPI_COMM_WORLD, &size);
    MPI(MPI_Comm_split_type, MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node);
    MPI(MPI_Comm_size, node, &near);
    MPI(MPI_Comm_free, &node);
    /* Signals stay the program's. */
    PETSC(PetscOptionsSetValue, NULL, "-no_signal_handler", "true");
    PETSC(PetscInitializeNoArguments);
    PETSC(PetscPushErrorHandler, PetscReturnErrorHandler, NULL);
    ranks[0] = rank;
    ranks[1] = size;
    ranks[2] = near;
    return 0;
}

int vp_finish(void) {
    PETSC(PetscFinalize);
    MPI(MPI_Finalize);
    return 0;
}

/* Ends all ranks. */
void vp_abort(int code) { MPI_Abort(MPI_COMM_WORLD, code); }

int vp_send(const char *bytes, int64_t length, int to) {
    for (int64_t at = 0; at < length; at += CHUNK) {
        int part = (int)(length - at < CHUNK ? length - at : CHUNK);
        MPI(MPI_Send, bytes + at, part, MPI_BYTE, to, TAG, MPI_COMM_WORLD);
    }
    return 0;
}

int vp_receive(char *bytes, int64_t length, int from) {
    for (int64_t at = 0; at < length; at += CHUNK) {
        int part = (int)(length - at < CHUNK ? length - at : CHUNK);
        MPI(MPI_Recv, bytes + at, part, MPI_BYTE, from, TAG, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    }
    return 0;
}

/* Sleeps until the first rank sends something: an idle rank leaves its core to the first one. */
int vp_idle(void) {
    int there = 0;
    for (;;) {
        MPI(MPI_Iprobe, 0, TAG, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
        if (there) return 0;
        usleep(200);
    }
}

int vp_agree(double *numbers, int64_t length) {
    for (int64_t at = 0; at < length; at += CHUNK) {
        int part = (int)(length - at < CHUNK ? length - at : CHUNK);
        MPI(MPI_Bcast, numbers + at, part, MPI_DOUBLE, 0, MPI_COMM_WORLD);
    }
    return 0;
}

/* On the first rank and from there: an all-reduce need not have the same bits everywhere. */
int vp_sum(double *numbers, int64_t length) {
    int rank = 0;
    MPI(MPI_Comm_rank, MPI_COMM_WORLD, &rank);
    for (int64_t at = 0; at < length; at += CHUNK) {
        int part = (int)(length - at < CHUNK ? length - at : CHUNK);
        double *own = numbers + at;
        MPI(MPI_Reduce, rank ? own : MPI_IN_PLACE, rank ? NULL : own, part, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
    }
    return vp_agree(numbers, length);
}

struct vp_matrix {
    Mat a;
    Vec x, y;
    PetscInt own, total;
};

void vp_matrix_free(struct vp_matrix *m) {
    if (!m) return;
    (void)VecDestroy(&m->x);
    (void)VecDestroy(&m->y);
    (void)MatDestroy(&m->a);
    free(m);
}

static PetscInt *narrow(const int64_t *numbers, int64_t length) {
    PetscInt *narrowed = malloc((size_t)(length > 0 ? length : 1) * sizeof *narrowed);
    for (int64_t i = 0; narrowed && i < length; i++) narrowed[i] = (PetscInt)numbers[i];
    return narrowed;
}

static int vectors(struct vp_matrix *m) {
    PETSC(VecCreateMPIWithArray, PETSC_COMM_WORLD, 1, m->own, m->total, NULL, &m->x);
    PETSC(VecCreateMPIWithArray, PETSC_COMM_WORLD, 1, m->own, m->total, NULL, &m->y);
    return 0;
}

static int fill(struct vp_matrix *m, const PetscInt *starts, const PetscInt *columns, const double *values) {
    PETSC(MatCreateMPIAIJWithArrays, PETSC_COMM_WORLD, m->own, m->own, m->total, m->total, starts, columns, values, &m->a);
    PETSC(MatSetOption, m->a, MAT_SYMMETRIC, PETSC_TRUE);
    return vectors(m);
}

/* Own rows, one after the other; `starts` has one more than there are rows. */
int vp_matrix(int64_t own, int64_t total, const int64_t *starts, const int64_t *columns, const double *values,
              struct vp_matrix **made) {
    if (total > PETSC_MAX_INT || starts[own] > PETSC_MAX_INT)
        return fail("MatCreateMPIAIJWithArrays", "more rows, or entries on one rank, than this PETSc counts with 32 bits: "
                                                 "more ranks, or a PETSc with 64-bit indices");
    struct vp_matrix *m = calloc(1, sizeof *m);
    PetscInt *s = narrow(starts, own + 1), *c = narrow(columns, starts[own]);
    int status = 1;
    if (!m || !s || !c) {
        fail("malloc", "not enough memory for the rows of a matrix");
    } else {
        m->own = (PetscInt)own;
        m->total = (PetscInt)total;
        status = fill(m, s, c, values);
    }
    free(s);
    free(c);
    if (status) vp_matrix_free(m);
    else *made = m;
    return status;
}

/* A matrix of the same rows, without entries. */
static struct vp_matrix *sized_like(const struct vp_matrix *from) {
    struct vp_matrix *m = calloc(1, sizeof *m);
    if (m) {
        m->own = from->own;
        m->total = from->total;
    } else {
        fail("malloc", "not enough memory for the rows of a matrix");
    }
    return m;
}

/* The same entries again, which are kept as long as one of the two is. */
static int share(const struct vp_matrix *from, struct vp_matrix *m) {
    PETSC(PetscObjectReference, (PetscObject)from->a);
    m->a = from->a;
    return vectors(m);
}

/* A copy with springs on the diagonal; rows are those of all ranks, of which this one has these. */
static int stiffen(const struct vp_matrix *from, const int64_t *rows, const double *springs, int64_t count,
                   struct vp_matrix *m) {
    PETSC(MatDuplicate, from->a, MAT_COPY_VALUES, &m->a);
    for (int64_t i = 0; i < count; i++)
        PETSC(MatSetValue, m->a, (PetscInt)rows[i], (PetscInt)rows[i], springs[i], ADD_VALUES);
    PETSC(MatAssemblyBegin, m->a, MAT_FINAL_ASSEMBLY);
    PETSC(MatAssemblyEnd, m->a, MAT_FINAL_ASSEMBLY);
    PETSC(MatSetOption, m->a, MAT_SYMMETRIC, PETSC_TRUE);
    return vectors(m);
}

static int multiple(const struct vp_matrix *from, double weight, struct vp_matrix *m) {
    PETSC(MatDuplicate, from->a, MAT_COPY_VALUES, &m->a);
    PETSC(MatScale, m->a, weight);
    PETSC(MatSetOption, m->a, MAT_SYMMETRIC, PETSC_TRUE);
    return vectors(m);
}

/* A matrix times a number. */
int vp_matrix_scaled(const struct vp_matrix *from, double weight, struct vp_matrix **made) {
    struct vp_matrix *m = sized_like(from);
    if (!m) return 1;
    if (multiple(from, weight, m)) {
        vp_matrix_free(m);
        return 1;
    }
    *made = m;
    return 0;
}

/* A matrix to factorise: the same one, or where there are springs on any rank a copy with them. */
int vp_matrix_held(const struct vp_matrix *from, int springy, const int64_t *rows, const double *springs, int64_t count,
                   struct vp_matrix **made) {
    struct vp_matrix *m = sized_like(from);
    if (!m) return 1;
    if (springy ? stiffen(from, rows, springs, count, m) : share(from, m)) {
        vp_matrix_free(m);
        return 1;
    }
    *made = m;
    return 0;
}

static int product(struct vp_matrix *m, Mat x, Mat y) {
    PETSC(MatProductCreateWithMat, m->a, x, NULL, y);
    PETSC(MatProductSetType, y, MATPRODUCT_AB);
    PETSC(MatProductSetFromOptions, y);
    PETSC(MatProductSymbolic, y);
    PETSC(MatProductNumeric, y);
    PETSC(MatProductClear, y);
    return 0;
}

/* y = A x, own rows of so many columns, which are contiguous: the entries are read for several columns at once. */
int vp_matrix_multiply(struct vp_matrix *m, const double *x, double *y, int64_t columns) {
    Mat right = NULL, left = NULL;
    PETSC(MatCreateDense, PETSC_COMM_WORLD, m->own, PETSC_DECIDE, m->total, (PetscInt)columns, (double *)x, &right);
    PETSC(MatCreateDense, PETSC_COMM_WORLD, m->own, PETSC_DECIDE, m->total, (PetscInt)columns, y, &left);
    int status = product(m, right, left);
    (void)MatDestroy(&right);
    (void)MatDestroy(&left);
    return status;
}

_Static_assert(LDBL_MANT_DIG > DBL_MANT_DIG, "vademecum sums some products in a precision beyond double");

/* y = (A - S) x, own rows of one column, of which x has all rows: each sum is made in extended precision and rounded once. S are
   springs on own rows, counted from the first of them. */
int vp_matrix_multiply_closely(struct vp_matrix *m, const double *x, const int64_t *rows, const double *springs, int64_t count_springs,
                               double *y) {
    PetscInt first = 0;
    PETSC(MatGetOwnershipRange, m->a, &first, NULL);
    for (PetscInt i = 0; i < m->own; i++) {
        const PetscInt *columns = NULL;
        const PetscScalar *values = NULL;
        PetscInt count = 0;
        long double sum = 0.0L;
        for (int64_t s = 0; s < count_springs; s++)
            if (rows[s] == i) sum -= (long double)springs[s] * x[first + i];
        PETSC(MatGetRow, m->a, first + i, &count, &columns, &values);
        for (PetscInt k = 0; k < count; k++) sum += (long double)values[k] * x[columns[k]];
        y[i] = (double)sum;
        PETSC(MatRestoreRow, m->a, first + i, &count, &columns, &values);
    }
    return 0;
}

/* The analysis of a factorisation L D L^T by MUMPS. With a folder, the factor goes there. `room` is the share of memory beside
   what is needed that its estimates count [per cent]. */
int vp_factor(struct vp_matrix *m, const char *folder, int64_t room, Mat *made) {
    MatFactorInfo info;
    PETSC(MatFactorInfoInitialize, &info);
    if (folder && setenv("MUMPS_OOC_TMPDIR", folder, 1)) return fail("malloc", "not enough memory for the name of a folder");
    PETSC(MatGetFactor, m->a, MATSOLVERMUMPS, MAT_FACTOR_CHOLESKY, made);
    PETSC(MatMumpsSetIcntl, *made, 22, folder ? 1 : 0);
    /* No ScaLAPACK for the last front: MUMPS does not count its negative pivots, which are how an indefinite matrix shows. */
    PETSC(MatMumpsSetIcntl, *made, 13, 1);
    PETSC(MatMumpsSetIcntl, *made, 14, (PetscInt)room);
    PETSC(MatCholeskyFactorSymbolic, *made, m->a, NULL, &info);
    return 0;
}

/* Fills the factor; `room` is the share of memory beside the estimate [per cent]. */
int vp_factor_fill(struct vp_matrix *m, Mat factor, int64_t room) {
    MatFactorInfo info;
    PETSC(MatFactorInfoInitialize, &info);
    PETSC(MatMumpsSetIcntl, factor, 14, (PetscInt)room);
    PETSC(MatFactorClearError, factor);
    PETSC(MatCholeskyFactorNumeric, factor, m->a, &info);
    return 0;
}

/* What MUMPS says: of all ranks, or of this one. */
int vp_factor_says(Mat factor, int of_all, int64_t which, int64_t *said) {
    PetscInt value = 0;
    if (of_all) PETSC(MatMumpsGetInfog, factor, (PetscInt)which, &value);
    else PETSC(MatMumpsGetInfo, factor, (PetscInt)which, &value);
    *said = value;
    return 0;
}

static int solve(Mat factor, Mat right, Mat left) {
    PETSC(MatMatSolve, factor, right, left);
    return 0;
}

/* answers = A^-1 forces, own rows of so many columns. */
int vp_factor_solve(struct vp_matrix *m, Mat factor, double *forces, double *answers, int64_t columns) {
    Mat right = NULL, left = NULL;
    PETSC(MatCreateDense, PETSC_COMM_WORLD, m->own, PETSC_DECIDE, m->total, (PetscInt)columns, forces, &right);
    PETSC(MatCreateDense, PETSC_COMM_WORLD, m->own, PETSC_DECIDE, m->total, (PetscInt)columns, answers, &left);
    int status = solve(factor, right, left);
    (void)MatDestroy(&right);
    (void)MatDestroy(&left);
    return status;
}

void vp_factor_free(Mat factor) { (void)MatDestroy(&factor); }

/* Own rows of the six rigid motions, made orthonormal: what a coarse level has to keep. */
static int near_kernel(struct vp_matrix *m, const double *motions) {
    Vec fields[6] = {NULL};
    MatNullSpace near = NULL;
    for (int k = 0; k < 6; k++) {
        double *values = NULL;
        PetscReal length = 0.0;
        PETSC(MatCreateVecs, m->a, NULL, &fields[k]);
        PETSC(VecGetArray, fields[k], &values);
        memcpy(values, motions + (size_t)k * (size_t)m->own, (size_t)m->own * sizeof *values);
        PETSC(VecRestoreArray, fields[k], &values);
        for (int pass = 0; pass < 2; pass++) {
            for (int other = 0; other < k; other++) {
                PetscScalar share = 0.0;
                PETSC(VecDot, fields[k], fields[other], &share);
                PETSC(VecAXPY, fields[k], -share, fields[other]);
            }
            PETSC(VecNormalize, fields[k], &length);
        }
        if (!(length > 0.0)) return fail("VecNormalize", "the nodes of the body lie on a line");
    }
    PETSC(MatNullSpaceCreate, PETSC_COMM_WORLD, PETSC_FALSE, 6, fields, &near);
    PETSC(MatSetNearNullSpace, m->a, near);
    PETSC(MatNullSpaceDestroy, &near);
    for (int k = 0; k < 6; k++) PETSC(VecDestroy, &fields[k]);
    return 0;
}

/* Conjugate gradients with algebraic multigrid (GAMG), to a relative tolerance in the norm of the preconditioner, which is
   close to that of the energy. `block`: dofs of a node stand together, three each. */
int vp_iteration(struct vp_matrix *m, const double *motions, int64_t block, double tolerance, KSP *made) {
    PC pc;
    /* Chebyshev with Jacobi needs no factor of its own, and does the same on every number of ranks. */
    PETSC(PetscOptionsSetValue, NULL, "-vademecum_pc_type", "gamg");
    PETSC(PetscOptionsSetValue, NULL, "-vademecum_mg_levels_ksp_type", "chebyshev");
    PETSC(PetscOptionsSetValue, NULL, "-vademecum_mg_levels_ksp_max_it", "3");
    PETSC(PetscOptionsSetValue, NULL, "-vademecum_mg_levels_pc_type", "jacobi");
    if (block) PETSC(MatSetBlockSize, m->a, 3);
    PETSC(MatSetOption, m->a, MAT_SPD, PETSC_TRUE);
    if (near_kernel(m, motions)) return 1;
    PETSC(KSPCreate, PETSC_COMM_WORLD, made);
    PETSC(KSPSetOptionsPrefix, *made, "vademecum_");
    PETSC(KSPSetOperators, *made, m->a, m->a);
    PETSC(KSPSetType, *made, KSPCG);
    PETSC(KSPSetNormType, *made, KSP_NORM_NATURAL);
    PETSC(KSPSetTolerances, *made, tolerance, 0.0, PETSC_DEFAULT, 2000);
    PETSC(KSPGetPC, *made, &pc);
    PETSC(PCSetType, pc, PCGAMG);
    PETSC(KSPSetFromOptions, *made);
    PETSC(KSPSetUp, *made);
    return 0;
}

static int iterate(struct vp_matrix *m, KSP ksp) {
    KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
    PetscInt taken = 0;
    char words[160];
    PETSC(KSPSolve, ksp, m->x, m->y);
    PETSC(KSPGetConvergedReason, ksp, &reason);
    if (reason > 0) return 0;
    PETSC(KSPGetIterationNumber, ksp, &taken);
    snprintf(words, sizeof words, "conjugate gradients stopped after %d iterations short of the tolerance (%s)", (int)taken,
             KSPConvergedReasons[reason]);
    return fail("KSPSolve", words);
}

/* answers = A^-1 forces, own rows of so many columns. */
int vp_iteration_solve(struct vp_matrix *m, KSP ksp, const double *forces, double *answers, int64_t columns) {
    for (int64_t c = 0; c < columns; c++) {
        PETSC(VecPlaceArray, m->x, forces + c * m->own);
        PETSC(VecPlaceArray, m->y, answers + c * m->own);
        int status = iterate(m, ksp);
        PETSC(VecResetArray, m->x);
        PETSC(VecResetArray, m->y);
        if (status) return status;
    }
    return 0;
}

void vp_iteration_free(KSP ksp) { (void)KSPDestroy(&ksp); }
