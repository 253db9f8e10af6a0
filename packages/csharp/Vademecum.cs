// vademecum for C#: steps elastic bodies in real time from vademecum files.
//
// One file over the C interface of the crate vademecum-c (the shared library: vademecum.dll, libvademecum.so or
// libvademecum.dylib). It needs C# 7.3 and .NET Standard 2.0, and no unsafe code, so it goes into a Unity
// project as it is.
//
// - Numbers are double and in SI units, as the file has them; Surface and Whole also fill vertex arrays of float.
// - Nothing is allocated by a step, by a load, or by what reads one number, vector or tensor.
// - What the library refuses is a VademecumException with its words, and nothing has changed then.
// - Bodies and worlds are handles over memory of their own, which Dispose, or the garbage collector, gives back.
// - A body belongs to one thread at a time, and so does a world with its bodies.

using System;
using System.IO;
using System.Runtime.InteropServices;
using System.Text;

namespace Vademecum
{
    /// <summary>Result of a call of the library. Below zero it was refused.</summary>
    public enum Status
    {
        /// <summary>Done.</summary>
        Ok = 0,
        /// <summary>Done; the body is at rest.</summary>
        AtRest = 1,
        /// <summary>Done; a state of other parameters or of the other precision was carried over.</summary>
        Carried = 2,
        /// <summary>An index or a name is not the file's.</summary>
        Argument = -1,
        /// <summary>Memory is too short.</summary>
        Memory = -2,
        /// <summary>The bytes are no vademecum file that can be stepped.</summary>
        File = -3,
        /// <summary>The file does not allow these options or this value.</summary>
        Bind = -4,
        /// <summary>A load is not finite, or at a place that is not loadable.</summary>
        Load = -5,
        /// <summary>The step is refused.</summary>
        Step = -6,
        /// <summary>The file does not hold what is asked for.</summary>
        Output = -7,
        /// <summary>The bytes are no saved state of this body.</summary>
        State = -8,
        /// <summary>The world cannot have this member, pair or joint.</summary>
        World = -9,
    }

    /// <summary>Numbers in which a body is stepped.</summary>
    public enum Precision
    {
        /// <summary>float: half the memory, and twice as fast.</summary>
        Single = 0,
        /// <summary>double.</summary>
        Double = 1,
    }

    /// <summary>What is read of a place.</summary>
    public enum Field
    {
        /// <summary>m.</summary>
        Displacement = 0,
        /// <summary>m/s.</summary>
        Velocity = 1,
    }

    /// <summary>Kinds of named things in a file.</summary>
    public enum Named
    {
        /// <summary>Probes.</summary>
        Probes = 0,
        /// <summary>Load patterns.</summary>
        Patterns = 1,
        /// <summary>Live parameters.</summary>
        Parameters = 2,
        /// <summary>Supports whose reactions the file gives.</summary>
        Supports = 3,
        /// <summary>Ports, where joints of a world hold.</summary>
        Ports = 4,
    }

    /// <summary>Structure of a step.</summary>
    public enum Structure
    {
        /// <summary>The exact one if the file was built for it, else the cheapest that keeps the tolerance.</summary>
        Auto = 0,
        /// <summary>One 3 by 3 block for each mode.</summary>
        Diagonal = 1,
        /// <summary>One dense map.</summary>
        Block = 2,
        /// <summary>One 2 by 2 block for each mode, without error of time.</summary>
        Exact = 3,
        /// <summary>Large displacements.</summary>
        Strain = 4,
    }

    /// <summary>Members of a pair whose nodes are held off the surface of the other.</summary>
    public enum ContactNodes
    {
        /// <summary>Of both.</summary>
        Both = 0,
        /// <summary>Of the first.</summary>
        First = 1,
        /// <summary>Of the second.</summary>
        Second = 2,
    }

    /// <summary>Kinds of joints.</summary>
    public enum JointKind
    {
        /// <summary>Two points stay together.</summary>
        Ball = 0,
        /// <summary>They do, and the members turn about the third axis of the first anchor.</summary>
        Hinge = 1,
        /// <summary>The second anchor stays on the third axis of the first, without turning.</summary>
        Slider = 2,
        /// <summary>Two points are no farther apart than a length.</summary>
        Cable = 3,
    }

    /// <summary>Something that the library refused, in its words.</summary>
    public sealed class VademecumException : Exception
    {
        /// <summary>Kind of the refusal.</summary>
        public Status Status { get; }

        /// <summary>Makes an exception of a status and the words of the library.</summary>
        public VademecumException(Status status, string words) : base(words)
        {
            Status = status;
        }
    }

    /// <summary>Three numbers: a place in m, a velocity in m/s, a force in N.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Vector
    {
        /// <summary>Along x.</summary>
        public double X;
        /// <summary>Along y.</summary>
        public double Y;
        /// <summary>Along z.</summary>
        public double Z;

        /// <summary>Makes a vector of its numbers.</summary>
        public Vector(double x, double y, double z)
        {
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>Its numbers.</summary>
        public override string ToString() =>
            string.Format(System.Globalization.CultureInfo.InvariantCulture, "({0:R}, {1:R}, {2:R})", X, Y, Z);
    }

    /// <summary>A rotation: a quaternion of length one that turns directions of a body into those of space.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Attitude
    {
        /// <summary>The real part.</summary>
        public double W;
        /// <summary>Along x.</summary>
        public double X;
        /// <summary>Along y.</summary>
        public double Y;
        /// <summary>Along z.</summary>
        public double Z;

        /// <summary>Makes a quaternion, the real part first.</summary>
        public Attitude(double w, double x, double y, double z)
        {
            W = w;
            X = x;
            Y = y;
            Z = z;
        }

        /// <summary>Not turned.</summary>
        public static Attitude Identity => new Attitude(1.0, 0.0, 0.0, 0.0);
    }

    /// <summary>A symmetric tensor: stress in Pa, or strain with the shear strains of the tensor.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Tensor
    {
        /// <summary>Along x.</summary>
        public double XX;
        /// <summary>Along y.</summary>
        public double YY;
        /// <summary>Along z.</summary>
        public double ZZ;
        /// <summary>Shear between x and y.</summary>
        public double XY;
        /// <summary>Shear between y and z.</summary>
        public double YZ;
        /// <summary>Shear between z and x.</summary>
        public double ZX;
    }

    /// <summary>Force and moment.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Wrench
    {
        /// <summary>N.</summary>
        public Vector Force;
        /// <summary>N m.</summary>
        public Vector Moment;
    }

    /// <summary>Options of a body; take <see cref="Default"/> and change it.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct BodyOptions
    {
        /// <summary>In which numbers the body is stepped; single by default.</summary>
        public Precision Precision;
        /// <summary>Structure of a step.</summary>
        public Structure Structure;
        /// <summary>Contacts with nodes of their own for which there is room in the residual flexibility; 16.</summary>
        public uint Contacts;
        /// <summary>With beta: nodes whose filtered forces are kept; 0: all loadable nodes.</summary>
        public uint FilteredNodes;
        /// <summary>0: outputs show the modes only.</summary>
        public uint Residual;
        /// <summary>Places that Compliance and FreeMotion take at most.</summary>
        public uint Places;
        /// <summary>Not 0: there is room for KeepLoads.</summary>
        public uint KeepLoads;
        /// <summary>Not 0: there is room for SolveStatics.</summary>
        public uint StaticField;
        /// <summary>Not 0: a body without supports flies.</summary>
        public uint Flight;
        /// <summary>Of the separated solution only the first so many terms; 0: all.</summary>
        public uint Terms;
        /// <summary>Sub-steps of a step at large displacements; 0: those of the file.</summary>
        public uint Substeps;
        /// <summary>Modes that are stepped of a file with live regions; 0: 32, or all of fewer.</summary>
        public uint Modes;
        /// <summary>Relative error of a trajectory that Structure.Auto accepts.</summary>
        public double Tolerance;
        /// <summary>Step in s; 0: the file's.</summary>
        public double TimeStep;
        /// <summary>Factor on the stiffness of the whole body.</summary>
        public double Stiffness;
        /// <summary>Factor on the density of the whole body.</summary>
        public double Density;
        /// <summary>Rayleigh damping by mass in 1/s; negative: the file's.</summary>
        public double Alpha;
        /// <summary>Rayleigh damping by stiffness in s; negative: the file's.</summary>
        public double Beta;
        /// <summary>An unloaded body whose state sums up to less is put at rest.</summary>
        public double RestBelow;
        /// <summary>Numerical viscosity at large displacements.</summary>
        public double Viscosity;

        /// <summary>The file as it was built: single precision, room for 16 contacts, residual flexibility.</summary>
        public static BodyOptions Default
        {
            get
            {
                BodyOptions options;
                Native.vdm_default_options(out options);
                return options;
            }
        }
    }

    /// <summary>Counts of a body.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Counts
    {
        private UIntPtr memory;
        /// <summary>Modes that are stepped.</summary>
        public uint Modes;
        /// <summary>Nodes; those of the surface come first.</summary>
        public uint Nodes;
        /// <summary>Nodes of the surface.</summary>
        public uint SurfaceNodes;
        /// <summary>Nodes that can be loaded; they come first.</summary>
        public uint LoadNodes;
        /// <summary>Triangles of the surface.</summary>
        public uint Triangles;
        /// <summary>Triangles that can be touched; they come first.</summary>
        public uint LoadTriangles;
        /// <summary>Probes.</summary>
        public uint Probes;
        /// <summary>Load patterns.</summary>
        public uint Patterns;
        /// <summary>Live parameters.</summary>
        public uint Parameters;
        /// <summary>Step in s.</summary>
        public double TimeStep;

        /// <summary>Bytes of memory that the body takes.</summary>
        public ulong Bytes => memory.ToUInt64();
    }

    /// <summary>A place of a body. Locate and AtNode give one.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Place
    {
        private uint count, frame;
        private uint n0, n1, n2, n3, n4, n5, n6, n7, n8, n9, n10, n11, n12, n13, n14, n15;
        private double w0, w1, w2, w3, w4, w5, w6, w7, w8, w9, w10, w11, w12, w13, w14, w15;
        private double radius;
        /// <summary>Position at rest in m.</summary>
        public Vector Position;
        /// <summary>Distance in m from the point that was asked for.</summary>
        public double Distance;

        /// <summary>Number of its nodes, 1 to 16.</summary>
        public int Count => (int)count;

        /// <summary>Its nodes and their weights, which sum to 1; arrays of 1 to 16.</summary>
        public Place(uint[] nodes, double[] weights) : this()
        {
            if (nodes.Length < 1 || nodes.Length > 16 || weights.Length != nodes.Length)
            {
                throw new ArgumentException("a place has 1 to 16 nodes, and a weight for each");
            }
            frame = uint.MaxValue;
            count = (uint)nodes.Length;
            Exchange(ref nodes, ref weights, true);
        }

        /// <summary>Its nodes, and their weights.</summary>
        public void Read(out uint[] nodes, out double[] weights)
        {
            nodes = new uint[Math.Min(count, 16)];
            weights = new double[nodes.Length];
            Exchange(ref nodes, ref weights, false);
        }

        private void Exchange(ref uint[] nodes, ref double[] weights, bool write)
        {
            for (int i = 0; i < nodes.Length; i++)
            {
                switch (i)
                {
                    case 0: Swap(ref n0, ref w0, ref nodes[i], ref weights[i], write); break;
                    case 1: Swap(ref n1, ref w1, ref nodes[i], ref weights[i], write); break;
                    case 2: Swap(ref n2, ref w2, ref nodes[i], ref weights[i], write); break;
                    case 3: Swap(ref n3, ref w3, ref nodes[i], ref weights[i], write); break;
                    case 4: Swap(ref n4, ref w4, ref nodes[i], ref weights[i], write); break;
                    case 5: Swap(ref n5, ref w5, ref nodes[i], ref weights[i], write); break;
                    case 6: Swap(ref n6, ref w6, ref nodes[i], ref weights[i], write); break;
                    case 7: Swap(ref n7, ref w7, ref nodes[i], ref weights[i], write); break;
                    case 8: Swap(ref n8, ref w8, ref nodes[i], ref weights[i], write); break;
                    case 9: Swap(ref n9, ref w9, ref nodes[i], ref weights[i], write); break;
                    case 10: Swap(ref n10, ref w10, ref nodes[i], ref weights[i], write); break;
                    case 11: Swap(ref n11, ref w11, ref nodes[i], ref weights[i], write); break;
                    case 12: Swap(ref n12, ref w12, ref nodes[i], ref weights[i], write); break;
                    case 13: Swap(ref n13, ref w13, ref nodes[i], ref weights[i], write); break;
                    case 14: Swap(ref n14, ref w14, ref nodes[i], ref weights[i], write); break;
                    default: Swap(ref n15, ref w15, ref nodes[i], ref weights[i], write); break;
                }
            }
        }

        private static void Swap(ref uint node, ref double weight, ref uint given, ref double by, bool write)
        {
            if (write)
            {
                node = given;
                weight = by;
            }
            else
            {
                given = node;
                by = weight;
            }
        }
    }

    /// <summary>A live parameter.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Parameter
    {
        /// <summary>Smallest value.</summary>
        public double Lower;
        /// <summary>Largest value.</summary>
        public double Upper;
        /// <summary>The value that the file was built around.</summary>
        public double Nominal;
        /// <summary>The value that the body has now.</summary>
        public double Value;
        private uint logarithmic;

        /// <summary>True if its range is best walked in the logarithm.</summary>
        public bool Logarithmic => logarithmic != 0;
    }

    /// <summary>Mass, centre and moments of inertia of a free body.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct RigidBody
    {
        /// <summary>kg.</summary>
        public double Mass;
        /// <summary>Its centre in m, in the coordinates of the file.</summary>
        public Vector Centre;
        /// <summary>Principal moments of inertia about the centre, in kg m².</summary>
        public Vector Moments;
        /// <summary>First principal axis in the coordinates of the file.</summary>
        public Vector FirstAxis;
        /// <summary>Second principal axis.</summary>
        public Vector SecondAxis;
        /// <summary>Third principal axis.</summary>
        public Vector ThirdAxis;
    }

    /// <summary>The rigid motion of a free body, in space.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Motion
    {
        /// <summary>Position of the centre in m.</summary>
        public Vector Position;
        /// <summary>Orientation.</summary>
        public Attitude Attitude;
        /// <summary>Momentum in kg m/s.</summary>
        public Vector Momentum;
        /// <summary>Angular momentum about the centre in kg m²/s.</summary>
        public Vector AngularMomentum;
    }

    /// <summary>Energies of the last change of live parameters, in J.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct CarriedEnergies
    {
        /// <summary>Kinetic energy that the stepped modes at the new values do not hold.</summary>
        public double LostKinetic;
        /// <summary>Elastic energy that they do not hold.</summary>
        public double LostElastic;
        /// <summary>Work of the change of stiffness.</summary>
        public double Work;
    }

    /// <summary>Options of a world; take <see cref="Default"/> and change it.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct WorldOptions
    {
        /// <summary>Acceleration of gravity in m/s².</summary>
        public Vector Gravity;
        /// <summary>Nodes and triangles are paired up to this distance in m; 0: a fiftieth of the smallest member.</summary>
        public double Reach;
        /// <summary>Largest change of a displacement in the last sweep in m; 0: 1e-9 of the smallest member.</summary>
        public double Tolerance;
        /// <summary>Share of an overlap that a step takes back, of what is above 1e-4 of the size of the smallest member.</summary>
        public double Recover;
        /// <summary>Most sweeps of a step.</summary>
        public uint Sweeps;
        /// <summary>Contacts for which there is room.</summary>
        public uint Contacts;
        /// <summary>Contacts near each contact for which there is room, of files with a contact patch.</summary>
        public uint Near;

        /// <summary>No gravity, room for 256 contacts.</summary>
        public static WorldOptions Default
        {
            get
            {
                WorldOptions options;
                Native.vdm_default_world_options(out options);
                return options;
            }
        }
    }

    /// <summary>Report of the steps of a world.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct WorldReport
    {
        private UIntPtr contacts, pressed, leftOut, sweeps, notConverged;
        /// <summary>Deepest overlap at the end of a step in m.</summary>
        public double WorstGap;
        /// <summary>Energy that contacts took from the members in J.</summary>
        public double EnergyGivenAway;

        /// <summary>Pairs of nodes and surfaces that were near each other in the last step.</summary>
        public ulong Contacts => contacts.ToUInt64();
        /// <summary>Those that carry a force.</summary>
        public ulong Pressed => pressed.ToUInt64();
        /// <summary>Most pairs of a step for which there was no room.</summary>
        public ulong LeftOut => leftOut.ToUInt64();
        /// <summary>Sweeps of all steps.</summary>
        public ulong Sweeps => sweeps.ToUInt64();
        /// <summary>Steps whose solution was not within the tolerance.</summary>
        public ulong NotConverged => notConverged.ToUInt64();
    }

    /// <summary>A contact of the last step, between a node of a member and the surface of another.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Touch
    {
        /// <summary>Member of the node, counted from 0.</summary>
        public uint First;
        /// <summary>Member of the surface.</summary>
        public uint Second;
        /// <summary>Position of the node in space, in m.</summary>
        public Vector Position;
        /// <summary>Normal of the surface, outwards.</summary>
        public Vector Normal;
        /// <summary>Force on the node in space, in N.</summary>
        public Vector Force;
        /// <summary>Normal force in N; 0 of a node that is near and does not touch.</summary>
        public double Pressure;
        /// <summary>Gap at the end of the step in m.</summary>
        public double Gap;
        /// <summary>Slip over the step in space, in m.</summary>
        public Vector Slip;
    }

    /// <summary>A joint after the last step.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct JointState
    {
        /// <summary>Force on the first member in N, and moment on it about its anchor in N m, in space.</summary>
        public Wrench Load;
        private uint broken;

        /// <summary>True if it was broken.</summary>
        public bool Broken => broken != 0;
    }

    /// <summary>Two members that may touch.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Pair
    {
        /// <summary>First member, counted from 0.</summary>
        public uint First;
        /// <summary>Second member.</summary>
        public uint Second;
        /// <summary>Whose nodes are held off the surface of the other.</summary>
        public ContactNodes Nodes;
        /// <summary>Coefficient of Coulomb's friction.</summary>
        public double Friction;
        /// <summary>Restitution of an impact that is shorter than a step, 0 to 1.</summary>
        public double Restitution;
    }

    /// <summary>Anchor of a joint on a member. AtPlace, AtPort and AtPoint make one.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Anchor
    {
        private int kind;
        private uint port;
        private Place place;
        private Vector point, first, second, third;

        /// <summary>A place of the surface of a body, for a ball joint or a cable.</summary>
        public static Anchor AtPlace(Place place) => new Anchor { kind = 0, place = place };
        /// <summary>A port of a body that is a frame, as Find(Named.Ports, name) counts them.</summary>
        public static Anchor AtPort(int port) => new Anchor { kind = 1, port = (uint)port };
        /// <summary>A point of a rigid member in its own coordinates, in m; its axes are those.</summary>
        public static Anchor AtPoint(Vector point) => new Anchor { kind = 2, point = point };
        /// <summary>The same with axes of its own, of length one and at right angles.</summary>
        public static Anchor AtPoint(Vector point, Vector first, Vector second, Vector third) =>
            new Anchor { kind = 2, point = point, first = first, second = second, third = third };
    }

    /// <summary>A joint between two members.</summary>
    [StructLayout(LayoutKind.Sequential)]
    public struct Joint
    {
        /// <summary>Its kind.</summary>
        public JointKind Kind;
        /// <summary>First member, counted from 0.</summary>
        public uint First;
        /// <summary>Second member.</summary>
        public uint Second;
        /// <summary>Its anchor on the first member.</summary>
        public Anchor FirstAnchor;
        /// <summary>Its anchor on the second member.</summary>
        public Anchor SecondAnchor;
        /// <summary>Length of a cable in m.</summary>
        public double Length;
        /// <summary>Compliance in m/N; 0 of a joint that holds.</summary>
        public double Compliance;
        /// <summary>Force at which it breaks in N; 0 of one that never does.</summary>
        public double BreaksAt;
    }

    /// <summary>A row of the table of what can be read of a body.</summary>
    public sealed class Quantity
    {
        /// <summary>Its number, which Body.Read takes.</summary>
        public uint Number { get; internal set; }
        /// <summary>Its name.</summary>
        public string Name { get; internal set; }
        /// <summary>Its unit.</summary>
        public string Unit { get; internal set; }
        /// <summary>Unit of its velocity; empty where it has none.</summary>
        public string RateUnit { get; internal set; }

        /// <summary>All quantities that this library knows.</summary>
        public static Quantity[] All()
        {
            var found = new System.Collections.Generic.List<Quantity>();
            Native.QuantityRow row;
            while (Native.vdm_quantity((uint)found.Count, out row) >= 0)
            {
                found.Add(new Quantity
                {
                    Number = (uint)found.Count,
                    Name = Native.Text(row.Name, 0, row.Name.Length),
                    Unit = Native.Text(row.Unit, 0, row.Unit.Length),
                    RateUnit = Native.Text(row.RateUnit, 0, row.RateUnit.Length),
                });
            }
            return found.ToArray();
        }

        /// <summary>The number of the quantity of this name; an unknown one is refused.</summary>
        public static uint Find(string name)
        {
            int found = Native.vdm_find_quantity(Native.Bytes(name));
            if (found < 0)
            {
                throw new VademecumException(Status.Argument, "there is no quantity `" + name + "`");
            }
            return (uint)found;
        }
    }

    /// <summary>The bytes of a vademecum file, in memory of its own. Its bodies share them.</summary>
    public sealed class BodyFile : IDisposable
    {
        private readonly Block bytes;
        private bool disposed;
        internal readonly UIntPtr Length;

        // Bodies keep the bytes after Dispose, so the handle alone does not say that it was called.
        internal Block Bytes => disposed ? throw new ObjectDisposedException(nameof(BodyFile)) : bytes;

        /// <summary>Version of the C interface that this source was written for.</summary>
        public const uint Abi = 4;

        /// <summary>Copies the bytes of a file.</summary>
        public BodyFile(byte[] bytes)
        {
            if (Native.vdm_abi() != Abi)
            {
                throw new VademecumException(Status.Argument,
                    "the library has version " + Native.vdm_abi() + " of the C interface; this source needs " + Abi);
            }
            this.bytes = new Block((ulong)bytes.Length);
            Marshal.Copy(bytes, 0, this.bytes.DangerousGetHandle(), bytes.Length);
            Length = new UIntPtr((ulong)bytes.Length);
        }

        /// <summary>Reads a file, without looking into it: Bind does.</summary>
        public static BodyFile Open(string path) => new BodyFile(File.ReadAllBytes(path));

        /// <summary>Compares every section with its checksum, which Bind does not.</summary>
        public void Verify()
        {
            var text = new byte[Native.TextLength];
            Native.Check(Native.vdm_verify(Bytes, Length, text, Native.TextSize), text);
        }

        /// <summary>Makes a body at rest, as the file was built.</summary>
        public Body Bind() => new Body(this, BodyOptions.Default);

        /// <summary>Makes a body at rest.</summary>
        public Body Bind(BodyOptions options) => new Body(this, options);

        /// <summary>Gives the bytes back once no body needs them.</summary>
        public void Dispose()
        {
            disposed = true;
            bytes.Dispose();
        }
    }

    /// <summary>A body that moves, with its loads. BodyFile.Bind makes one.</summary>
    public sealed class Body : IDisposable
    {
        private readonly BodyHandle handle;
        private readonly Counts counts;
        private bool disposed;

        // A world keeps the handle after Dispose.
        internal BodyHandle Handle => disposed ? throw new ObjectDisposedException(nameof(Body)) : handle;

        internal Body(BodyFile file, BodyOptions options)
        {
            var text = new byte[Native.TextLength];
            Native.Check(Native.vdm_measure(file.Bytes, file.Length, ref options, out counts, text, Native.TextSize), text);
            Options = options;
            handle = new BodyHandle(file.Bytes, counts.Bytes);
            try
            {
                IntPtr body;
                Native.Check(Native.vdm_bind(file.Bytes, file.Length, ref options, handle.Memory,
                    new UIntPtr(counts.Bytes), out body, text, Native.TextSize), text);
                handle.Take(body);
            }
            catch
            {
                handle.Dispose();
                throw;
            }
        }

        /// <summary>The options that it was bound with.</summary>
        public BodyOptions Options { get; }
        /// <summary>Numbers of modes, nodes, triangles, probes, patterns and parameters.</summary>
        public Counts Counts => counts;
        /// <summary>Step in s.</summary>
        public double TimeStep => counts.TimeStep;
        /// <summary>Structure of its step.</summary>
        public Structure Structure => (Structure)Native.vdm_structure(Handle);

        /// <summary>Gives its memory back.</summary>
        public void Dispose()
        {
            disposed = true;
            handle.Dispose();
        }

        private void Check(int status)
        {
            if (status < 0)
            {
                var words = Native.Text(Native.vdm_message(Handle));
                GC.KeepAlive(this);
                throw new VademecumException((Status)status, words);
            }
        }

        // Names.

        /// <summary>The number of what has this name, counted from 0; an unknown name is refused.</summary>
        public int Find(Named kind, string name)
        {
            int found = Native.vdm_find(Handle, (int)kind, Native.Bytes(name));
            if (found < 0)
            {
                throw new VademecumException(Status.Argument, "the file has none of the " + kind + " named `" + name + "`");
            }
            return found;
        }

        /// <summary>The name of number `index` of a kind.</summary>
        public string Name(Named kind, int index)
        {
            var text = new byte[Native.TextLength];
            Check(Native.vdm_name(Handle, (int)kind, (uint)index, text, Native.TextSize));
            return Native.Text(text, 0, text.Length);
        }

        // Places.

        /// <summary>The place of the loadable surface at rest that is nearest to a point in m.</summary>
        public Place Locate(Vector point)
        {
            Place place;
            Check(Native.vdm_locate(Handle, ref point, out place));
            return place;
        }

        /// <summary>The place that is a loadable node.</summary>
        public Place AtNode(int node)
        {
            Place place;
            Check(Native.vdm_at_node(Handle, (uint)node, out place));
            return place;
        }

        // Loads. They stay until Clear; on a body that flies they act for one step.

        /// <summary>Takes all loads away.</summary>
        public void Clear() => Check(Native.vdm_clear(Handle));

        /// <summary>Adds a force in N at a place.</summary>
        public void Push(ref Place place, Vector force) => Check(Native.vdm_push(Handle, ref place, ref force));

        /// <summary>Adds a force in N that goes linearly from `start` to `end` over one step.</summary>
        public void PushRamp(ref Place place, Vector start, Vector end) =>
            Check(Native.vdm_push_ramp(Handle, ref place, ref start, ref end));

        /// <summary>Adds load pattern number `pattern`, times an amplitude.</summary>
        public void PushPattern(int pattern, double amplitude) =>
            Check(Native.vdm_push_pattern(Handle, (uint)pattern, amplitude));

        /// <summary>Adds a load pattern whose amplitude goes linearly from `start` to `end` over one step.</summary>
        public void PushPatternRamp(int pattern, double start, double end) =>
            Check(Native.vdm_push_pattern_ramp(Handle, (uint)pattern, start, end));

        /// <summary>Adds the inertia of a base that moves so, in its own axes: m/s², rad/s and rad/s².</summary>
        public void PushBase(Vector acceleration, Vector angularVelocity, Vector angularAcceleration) =>
            Check(Native.vdm_push_base(Handle, ref acceleration, ref angularVelocity, ref angularAcceleration));

        /// <summary>Adds the centrifugal forces of a step in which the host turns a free body, in rad/s.</summary>
        public void PushSpin(Vector before, Vector after) => Check(Native.vdm_push_spin(Handle, ref before, ref after));

        /// <summary>Pulls a body that flies at its centre with a force in N of space.</summary>
        public void Pull(Vector force) => Check(Native.vdm_pull(Handle, ref force));

        /// <summary>Keeps the loads as they are; of a body bound with KeepLoads.</summary>
        public void KeepLoads() => Check(Native.vdm_keep_loads(Handle));

        /// <summary>The loads become those that were kept.</summary>
        public void RecallLoads() => Check(Native.vdm_recall_loads(Handle));

        // Steps and states.

        /// <summary>Makes one step. False once the body rests.</summary>
        public bool Step() => Step(1);

        /// <summary>Makes so many steps under the loads at hand. False once the body rests.</summary>
        public bool Step(ulong steps)
        {
            int status = Native.vdm_step(Handle, steps);
            Check(status);
            return status != (int)Status.AtRest;
        }

        /// <summary>Puts the body at rest where the file has it. Loads stay.</summary>
        public void Rest() => Check(Native.vdm_rest(Handle));

        /// <summary>Sets the reduced coordinates and their rates, as many numbers as modes each.</summary>
        public void Set(double[] zeta, double[] rates)
        {
            Same(zeta.Length, rates.Length);
            Check(Native.vdm_set(Handle, zeta, rates, Native.Size(zeta.Length)));
        }

        /// <summary>Reads the reduced coordinates and their rates, as many numbers as modes each.</summary>
        public void Coordinates(double[] zeta, double[] rates)
        {
            Same(zeta.Length, rates.Length);
            Check(Native.vdm_coordinates(Handle, zeta, rates, Native.Size(zeta.Length)));
        }

        /// <summary>Everything that a step changes, as bytes. Loads are not part of it.</summary>
        public byte[] Save()
        {
            var bytes = new byte[(long)Native.vdm_saved_length(Handle).ToUInt64()];
            UIntPtr written;
            Check(Native.vdm_save(Handle, bytes, Native.Size(bytes.Length), out written));
            Array.Resize(ref bytes, (int)written.ToUInt64());
            return bytes;
        }

        /// <summary>Takes back what Save gave. True if every bit is as it was, false if a state of other parameters or
        /// of the other precision was carried over.</summary>
        public bool Restore(byte[] saved)
        {
            int status = Native.vdm_restore(Handle, saved, Native.Size(saved.Length));
            Check(status);
            return status == (int)Status.Ok;
        }

        // Live parameters.

        /// <summary>Range and value of a live parameter.</summary>
        public Parameter Parameter(int parameter)
        {
            Parameter found;
            Check(Native.vdm_parameter(Handle, (uint)parameter, out found));
            return found;
        }

        /// <summary>Sets live parameters by their numbers, all or none. Clear the loads, and add them again.</summary>
        public void SetParameters(uint[] parameters, double[] values)
        {
            Same(parameters.Length, values.Length);
            Check(Native.vdm_set_parameters(Handle, parameters, values, Native.Size(values.Length)));
        }

        /// <summary>Sets one live parameter by its name. Clear the loads, and add them again.</summary>
        public void SetParameter(string name, double value) =>
            SetParameters(new[] { (uint)Find(Named.Parameters, name) }, new[] { value });

        /// <summary>Energies of the last change of live parameters of a file with live regions.</summary>
        public CarriedEnergies Carried()
        {
            CarriedEnergies found;
            Check(Native.vdm_carried(Handle, out found));
            return found;
        }

        // Outputs.

        /// <summary>Value of a probe, in the unit of the probe.</summary>
        public double Probe(int probe, Field field = Field.Displacement)
        {
            double value;
            Check(Native.vdm_probe(Handle, (uint)probe, (int)field, out value));
            return value;
        }

        /// <summary>Displacement in m or velocity in m/s of a place, in the axes of the body.</summary>
        public Vector Point(ref Place place, Field field = Field.Displacement)
        {
            Vector value;
            Check(Native.vdm_point(Handle, ref place, (int)field, out value));
            return value;
        }

        /// <summary>Displacement in m or velocity in m/s of a node.</summary>
        public Vector Node(int node, Field field = Field.Displacement)
        {
            Vector value;
            Check(Native.vdm_node(Handle, (uint)node, (int)field, out value));
            return value;
        }

        /// <summary>Fills three numbers for each node of the surface; of a body in single precision.</summary>
        public void Surface(float[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_surface_f32(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>The same of a body in double precision.</summary>
        public void Surface(double[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_surface_f64(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>The same into memory of `numbers` floats that stays where it is, such as a NativeArray of Unity.</summary>
        public void Surface(IntPtr values, int numbers, Field field = Field.Displacement) =>
            Check(Native.vdm_surface_f32(Handle, (int)field, values, Native.Size(numbers)));

        /// <summary>Fills three numbers for each node; of a body in single precision.</summary>
        public void Whole(float[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_whole_f32(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>The same of a body in double precision.</summary>
        public void Whole(double[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_whole_f64(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>Solves for the static answer of the whole body to the loads of the last step.</summary>
        public void SolveStatics() => Check(Native.vdm_solve_statics(Handle));

        /// <summary>Whole with the answer of SolveStatics; of a body in single precision.</summary>
        public void WholeWithStatics(float[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_whole_with_statics_f32(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>The same of a body in double precision.</summary>
        public void WholeWithStatics(double[] values, Field field = Field.Displacement) =>
            Check(Native.vdm_whole_with_statics_f64(Handle, (int)field, values, Native.Size(values.Length)));

        /// <summary>Kinetic plus elastic energy in J.</summary>
        public double Energy()
        {
            double value;
            Check(Native.vdm_energy(Handle, out value));
            return value;
        }

        /// <summary>Force and moment that a support exerts on the body.</summary>
        public Wrench Reaction(int support)
        {
            Wrench value;
            Check(Native.vdm_reaction(Handle, (uint)support, out value));
            return value;
        }

        /// <summary>Number of points that have a stress.</summary>
        public int StressPoints => (int)Native.vdm_stress_points(Handle);

        /// <summary>Node of the file, and region of the mesh, of a point that has a stress.</summary>
        public void StressPoint(int point, out int node, out int region)
        {
            var found = new uint[2];
            Check(Native.vdm_stress_point(Handle, (uint)point, found));
            node = (int)found[0];
            region = (int)found[1];
        }

        /// <summary>Stress at such a point in Pa.</summary>
        public Tensor Stress(int point)
        {
            Tensor value;
            Check(Native.vdm_stress(Handle, (uint)point, out value));
            return value;
        }

        /// <summary>Strain at such a point.</summary>
        public Tensor Strain(int point)
        {
            Tensor value;
            Check(Native.vdm_strain(Handle, (uint)point, out value));
            return value;
        }

        /// <summary>Von Mises' equivalent stress at such a point in Pa.</summary>
        public double VonMises(int point)
        {
            double value;
            Check(Native.vdm_von_mises(Handle, (uint)point, out value));
            return value;
        }

        /// <summary>Number of instances of a quantity in the body; 0 where it does not have it.</summary>
        public int Count(uint quantity) => (int)Native.vdm_count(Handle, quantity).ToUInt64();

        /// <summary>Reads any quantity, in the units of its row.</summary>
        public double[] Read(uint quantity, int index = 0, Field field = Field.Displacement)
        {
            var values = new double[(int)Native.vdm_length(Handle, quantity).ToUInt64()];
            Check(Native.vdm_read(Handle, quantity, Native.Size(index), (int)field, values, Native.Size(values.Length)));
            return values;
        }

        /// <summary>Positions of the nodes of the surface at rest in m: three numbers a node.</summary>
        public double[] Positions()
        {
            var values = new double[3 * (long)counts.SurfaceNodes];
            Check(Native.vdm_positions(Handle, values, Native.Size(values.Length)));
            return values;
        }

        /// <summary>The triangles of the surface: three nodes each, counterclockwise from outside.</summary>
        public uint[] Triangles()
        {
            var values = new uint[3 * (long)counts.Triangles];
            Check(Native.vdm_triangles(Handle, values, Native.Size(values.Length)));
            return values;
        }

        // Contacts of a solver of one's own.

        /// <summary>Displacement in m of each place at the end of the coming step for a force of 1 N at each of them:
        /// 3 count rows and columns, row by row. `places` are at most BodyOptions.Places.</summary>
        public double[] Compliance(Place[] places)
        {
            var values = new double[9 * (long)places.Length * places.Length];
            Check(Native.vdm_compliance(Handle, places, Native.Size(places.Length), values));
            return values;
        }

        /// <summary>Displacement in m of each place at the end of the coming step under the loads at hand.</summary>
        public Vector[] FreeMotion(Place[] places)
        {
            var values = new Vector[places.Length];
            Check(Native.vdm_free_motion(Handle, places, Native.Size(places.Length), values));
            return values;
        }

        // Free bodies.

        /// <summary>Mass, centre and moments of inertia of a body without supports.</summary>
        public RigidBody RigidBody()
        {
            RigidBody found;
            Check(Native.vdm_rigid_body(Handle, out found));
            return found;
        }

        /// <summary>Throws a body that flies from where the file has it: m/s and rad/s.</summary>
        public void Throw(Vector velocity, Vector spin) => Check(Native.vdm_throw(Handle, ref velocity, ref spin));

        /// <summary>The motion in space of a body that flies; set it to put the body elsewhere.</summary>
        public Motion Motion
        {
            get
            {
                Motion found;
                Check(Native.vdm_motion(Handle, out found));
                return found;
            }
            set { Check(Native.vdm_set_motion(Handle, ref value)); }
        }

        /// <summary>The motion in space at the end of the coming step under the loads at hand.</summary>
        public Motion Ahead()
        {
            Motion found;
            Check(Native.vdm_ahead(Handle, out found));
            return found;
        }

        /// <summary>Position in m or velocity in m/s in space of a place of a body that flies.</summary>
        public Vector InSpace(ref Place place, Field field = Field.Displacement)
        {
            Vector value;
            Check(Native.vdm_in_space(Handle, ref place, (int)field, out value));
            return value;
        }

        private static void Same(int one, int other)
        {
            if (one != other)
            {
                throw new ArgumentException("expected two arrays of one length, found " + one + " and " + other);
            }
        }
    }

    /// <summary>A member of a world: a body, or a rigid body within a surface.</summary>
    public sealed class Member
    {
        /// <summary>A body; null of a rigid member.</summary>
        public Body Body;
        /// <summary>Nodes of a rigid member in its own coordinates in m: three numbers each.</summary>
        public double[] Nodes = new double[0];
        /// <summary>Its triangles: three nodes each, counterclockwise from outside.</summary>
        public uint[] Triangles = new uint[0];
        /// <summary>Mass and moments of a rigid member that moves; a mass of 0: the host leads it.</summary>
        public RigidBody Mass;
        /// <summary>Motion of a rigid member that moves; of one that is led, and of a body with supports, the place of
        /// the origin of its coordinates and its rotation. A body that flies has a motion of its own.</summary>
        public Motion Motion = new Motion { Attitude = Attitude.Identity };
    }

    /// <summary>Bodies that move, touch with friction, and turn about joints. Its bodies stay in use by the host between
    /// its steps, and live at least as long as it does.</summary>
    public sealed class World : IDisposable
    {
        private readonly WorldHandle handle;
        private readonly Member[] members;

        /// <summary>Binds a world; joints hold the members as they stand.</summary>
        public World(Member[] members, Pair[] pairs, Joint[] joints, WorldOptions options)
        {
            this.members = (Member[])members.Clone();
            handle = new WorldHandle();
            var text = new byte[Native.TextLength];
            try
            {
                var given = new Native.MemberOf[members.Length];
                for (int i = 0; i < members.Length; i++)
                {
                    var member = members[i];
                    if (member.Nodes.Length % 3 != 0 || member.Triangles.Length % 3 != 0)
                    {
                        throw new ArgumentException("nodes and triangles have three numbers each");
                    }
                    given[i] = new Native.MemberOf
                    {
                        Body = member.Body == null ? IntPtr.Zero : handle.Keep(member.Body.Handle),
                        Nodes = handle.Copy(member.Nodes),
                        Triangles = handle.Copy(member.Triangles),
                        NodeCount = Native.Size(member.Nodes.Length / 3),
                        TriangleCount = Native.Size(member.Triangles.Length / 3),
                        Mass = member.Mass,
                        Motion = member.Motion,
                    };
                }
                UIntPtr bytes;
                Native.Check(Native.vdm_world_measure(given, Native.Size(given.Length), pairs, Native.Size(pairs.Length),
                    joints, Native.Size(joints.Length), ref options, out bytes, text, Native.TextSize), text);
                IntPtr world;
                Native.Check(Native.vdm_world_bind(given, Native.Size(given.Length), pairs, Native.Size(pairs.Length),
                    joints, Native.Size(joints.Length), ref options, handle.Lend(bytes.ToUInt64()), bytes, out world, text,
                    Native.TextSize), text);
                handle.Take(world);
            }
            catch
            {
                handle.Dispose();
                throw;
            }
        }

        /// <summary>Its members.</summary>
        public System.Collections.Generic.IReadOnlyList<Member> Members => members;

        /// <summary>Gives its memory back. The bodies stay.</summary>
        public void Dispose() => handle.Dispose();

        private void Check(int status)
        {
            if (status < 0)
            {
                var words = Native.Text(Native.vdm_world_message(handle));
                GC.KeepAlive(this);
                throw new VademecumException((Status)status, words);
            }
        }

        /// <summary>Steps all members so many times. Loads act in the first step.</summary>
        public WorldReport Step(ulong steps)
        {
            WorldReport report;
            Check(Native.vdm_world_step(handle, steps, out report));
            return report;
        }

        /// <summary>Kinetic and elastic energy of members, contacts and joints in J.</summary>
        public double Energy()
        {
            double value;
            Check(Native.vdm_world_energy(handle, out value));
            return value;
        }

        /// <summary>Place of the origin of the coordinates of a member in m, and its rotation.</summary>
        public void Pose(int member, out Vector position, out Attitude attitude) =>
            Check(Native.vdm_world_pose(handle, (uint)member, out position, out attitude));

        /// <summary>Puts a body with supports elsewhere, or leads a rigid member without a mass to the end of the coming
        /// step.</summary>
        public void Lead(int member, Vector position, Attitude attitude) =>
            Check(Native.vdm_world_lead(handle, (uint)member, ref position, ref attitude));

        /// <summary>The motion of a rigid member. That of a body is Body.Motion.</summary>
        public Motion MotionOf(int member)
        {
            Motion found;
            Check(Native.vdm_world_motion(handle, (uint)member, out found));
            return found;
        }

        /// <summary>Puts a rigid member elsewhere, or lets it move otherwise; call Forget after it.</summary>
        public void SetMotion(int member, Motion motion) =>
            Check(Native.vdm_world_set_motion(handle, (uint)member, ref motion));

        /// <summary>Pushes a rigid member at a point of space in m with a force in N, in the coming step.</summary>
        public void Push(int member, Vector point, Vector force) =>
            Check(Native.vdm_world_push(handle, (uint)member, ref point, ref force));

        /// <summary>Position in m or velocity in m/s in space of a place of a body.</summary>
        public Vector InSpace(int member, ref Place place, Field field = Field.Displacement)
        {
            Vector value;
            Check(Native.vdm_world_in_space(handle, (uint)member, ref place, (int)field, out value));
            return value;
        }

        /// <summary>Fills in contacts of the last step, as many as there is room for, and gives the number of all.</summary>
        public int Touches(Touch[] touches)
        {
            UIntPtr count;
            Check(Native.vdm_world_touches(handle, touches, Native.Size(touches.Length), out count));
            return (int)count.ToUInt64();
        }

        /// <summary>Force and moment of a joint in the last step.</summary>
        public JointState JointOf(int joint)
        {
            JointState found;
            Check(Native.vdm_world_joint(handle, (uint)joint, out found));
            return found;
        }

        /// <summary>Breaks a joint.</summary>
        public void Break(int joint) => Check(Native.vdm_world_break(handle, (uint)joint));

        /// <summary>Forgets the contacts of the last step: after a member was put elsewhere.</summary>
        public void Forget() => Check(Native.vdm_world_forget(handle));

        /// <summary>Contacts, joints, placements, and motions of rigid members. With Body.Save of each body the world goes
        /// on from there bit by bit.</summary>
        public double[] Save()
        {
            var saved = new double[(long)Native.vdm_world_saved_length(handle).ToUInt64()];
            Check(Native.vdm_world_save(handle, saved, Native.Size(saved.Length)));
            return saved;
        }

        /// <summary>Takes back what Save gave.</summary>
        public void Restore(double[] saved) =>
            Check(Native.vdm_world_restore(handle, saved, Native.Size(saved.Length)));
    }

    /// <summary>Memory outside of the garbage collector, aligned to 16 bytes.</summary>
    internal sealed class Block : SafeHandle
    {
        private readonly IntPtr start;

        public Block(ulong bytes) : base(IntPtr.Zero, true)
        {
            start = Marshal.AllocHGlobal(new IntPtr(checked((long)bytes + 16)));
            SetHandle(new IntPtr((start.ToInt64() + 15) & ~15L));
        }

        public override bool IsInvalid => handle == IntPtr.Zero;

        protected override bool ReleaseHandle()
        {
            Marshal.FreeHGlobal(start);
            return true;
        }
    }

    /// <summary>A handle of the library, in memory that is its own and over others that it keeps.</summary>
    internal abstract class Lent : SafeHandle
    {
        private readonly System.Collections.Generic.List<SafeHandle> kept =
            new System.Collections.Generic.List<SafeHandle>();
        private readonly System.Collections.Generic.List<Block> own = new System.Collections.Generic.List<Block>();

        protected Lent() : base(IntPtr.Zero, true)
        {
            // So that it is released in any case.
            SetHandle(new IntPtr(-1));
        }

        public override bool IsInvalid => handle == IntPtr.Zero;

        public void Take(IntPtr bound) => SetHandle(bound);

        public IntPtr Keep(SafeHandle other)
        {
            bool added = false;
            other.DangerousAddRef(ref added);
            kept.Add(other);
            return other.DangerousGetHandle();
        }

        public IntPtr Lend(ulong bytes)
        {
            var block = new Block(bytes);
            own.Add(block);
            return Keep(block);
        }

        protected override bool ReleaseHandle()
        {
            foreach (var other in kept)
            {
                other.DangerousRelease();
            }
            foreach (var block in own)
            {
                block.Dispose();
            }
            return true;
        }
    }

    internal sealed class BodyHandle : Lent
    {
        public readonly IntPtr Memory;

        public BodyHandle(Block file, ulong bytes)
        {
            Keep(file);
            Memory = Lend(bytes);
        }
    }

    internal sealed class WorldHandle : Lent
    {
        public IntPtr Copy(double[] values)
        {
            var memory = Lend(8 * (ulong)values.Length);
            Marshal.Copy(values, 0, memory, values.Length);
            return memory;
        }

        public IntPtr Copy(uint[] values)
        {
            var memory = Lend(4 * (ulong)values.Length);
            Marshal.Copy((int[])(object)values, 0, memory, values.Length);
            return memory;
        }
    }

    /// <summary>The C interface, call by call.</summary>
    internal static class Native
    {
        private const string Library = "vademecum";
        public const int TextLength = 1024;
        public static readonly UIntPtr TextSize = new UIntPtr(TextLength);

        public static UIntPtr Size(int count) => new UIntPtr(checked((ulong)count));

        public static byte[] Bytes(string text) => Encoding.UTF8.GetBytes(text + "\0");

        public static string Text(byte[] bytes, int start, int most)
        {
            int end = Array.IndexOf(bytes, (byte)0, start, most);
            return Encoding.UTF8.GetString(bytes, start, (end < 0 ? start + most : end) - start);
        }

        public static string Text(IntPtr text)
        {
            int length = 0;
            while (Marshal.ReadByte(text, length) != 0)
            {
                length++;
            }
            var bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }

        public static void Check(int status, byte[] text)
        {
            if (status < 0)
            {
                throw new VademecumException((Status)status, Text(text, 0, text.Length));
            }
        }

        [StructLayout(LayoutKind.Sequential)]
        public struct MemberOf
        {
            public IntPtr Body, Nodes, Triangles;
            public UIntPtr NodeCount, TriangleCount;
            public RigidBody Mass;
            public Motion Motion;
        }

        [StructLayout(LayoutKind.Sequential)]
        public struct QuantityRow
        {
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 24)] public byte[] Name;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public byte[] Unit;
            [MarshalAs(UnmanagedType.ByValArray, SizeConst = 8)] public byte[] RateUnit;
            public uint Scalar;
        }

#pragma warning disable IDE1006 // The names are those of the C interface.
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern uint vdm_abi();
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void vdm_default_options(out BodyOptions options);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_measure(Block file, UIntPtr length, ref BodyOptions options,
            out Counts needs, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_bind(Block file, UIntPtr length, ref BodyOptions options,
            IntPtr memory, UIntPtr bytes, out IntPtr body, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_verify(Block file, UIntPtr length, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr vdm_message(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_structure(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_name(BodyHandle body, int kind, uint index, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_find(BodyHandle body, int kind, byte[] name);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_locate(BodyHandle body, ref Vector point, out Place place);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_at_node(BodyHandle body, uint node, out Place place);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_clear(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push(BodyHandle body, ref Place place, ref Vector force);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push_ramp(BodyHandle body, ref Place place, ref Vector start, ref Vector end);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push_pattern(BodyHandle body, uint pattern, double amplitude);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push_pattern_ramp(BodyHandle body, uint pattern, double start, double end);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push_base(BodyHandle body, ref Vector acceleration, ref Vector velocity,
            ref Vector angular);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_push_spin(BodyHandle body, ref Vector before, ref Vector after);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_pull(BodyHandle body, ref Vector force);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_keep_loads(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_recall_loads(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_step(BodyHandle body, ulong steps);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_rest(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_set(BodyHandle body, double[] zeta, double[] rates, UIntPtr count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_coordinates(BodyHandle body, [Out] double[] zeta, [Out] double[] rates, UIntPtr count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern UIntPtr vdm_saved_length(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_save(BodyHandle body, [Out] byte[] bytes, UIntPtr capacity, out UIntPtr written);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_restore(BodyHandle body, byte[] bytes, UIntPtr length);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_parameter(BodyHandle body, uint parameter, out Parameter found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_set_parameters(BodyHandle body, uint[] ids, double[] values, UIntPtr count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_carried(BodyHandle body, out CarriedEnergies found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_probe(BodyHandle body, uint probe, int field, out double value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_point(BodyHandle body, ref Place place, int field, out Vector value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_node(BodyHandle body, uint node, int field, out Vector value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_surface_f32(BodyHandle body, int field, [Out] float[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_surface_f32(BodyHandle body, int field, IntPtr values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_surface_f64(BodyHandle body, int field, [Out] double[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_whole_f32(BodyHandle body, int field, [Out] float[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_whole_f64(BodyHandle body, int field, [Out] double[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_solve_statics(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_whole_with_statics_f32(BodyHandle body, int field, [Out] float[] values,
            UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_whole_with_statics_f64(BodyHandle body, int field, [Out] double[] values,
            UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_energy(BodyHandle body, out double value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_reaction(BodyHandle body, uint support, out Wrench value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern uint vdm_stress_points(BodyHandle body);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_stress_point(BodyHandle body, uint point, [Out] uint[] found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_stress(BodyHandle body, uint point, out Tensor value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_strain(BodyHandle body, uint point, out Tensor value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_von_mises(BodyHandle body, uint point, out double value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_quantity(uint quantity, out QuantityRow row);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_find_quantity(byte[] name);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern UIntPtr vdm_count(BodyHandle body, uint quantity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern UIntPtr vdm_length(BodyHandle body, uint quantity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_read(BodyHandle body, uint quantity, UIntPtr index, int field, [Out]
            double[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_positions(BodyHandle body, [Out] double[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_triangles(BodyHandle body, [Out] uint[] values, UIntPtr numbers);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_compliance(BodyHandle body, Place[] places, UIntPtr count, [Out] double[] values);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_free_motion(BodyHandle body, Place[] places, UIntPtr count, [Out] Vector[] values);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_rigid_body(BodyHandle body, out RigidBody found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_throw(BodyHandle body, ref Vector velocity, ref Vector spin);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_motion(BodyHandle body, out Motion found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_set_motion(BodyHandle body, ref Motion motion);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_ahead(BodyHandle body, out Motion found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_in_space(BodyHandle body, ref Place place, int field, out Vector value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern void vdm_default_world_options(out WorldOptions options);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_measure(MemberOf[] members, UIntPtr memberCount, Pair[] pairs,
            UIntPtr pairCount, Joint[] joints, UIntPtr jointCount, ref WorldOptions options, out UIntPtr bytes,
            [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_bind(MemberOf[] members, UIntPtr memberCount, Pair[] pairs, UIntPtr
            pairCount, Joint[] joints, UIntPtr jointCount, ref WorldOptions options, IntPtr memory, UIntPtr
            bytes, out IntPtr world, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern IntPtr vdm_world_message(WorldHandle world);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_step(WorldHandle world, ulong steps, out WorldReport report);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_energy(WorldHandle world, out double value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_pose(WorldHandle world, uint member, out Vector position, out Attitude attitude);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_lead(WorldHandle world, uint member, ref Vector position, ref Attitude attitude);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_motion(WorldHandle world, uint member, out Motion found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_set_motion(WorldHandle world, uint member, ref Motion motion);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_push(WorldHandle world, uint member, ref Vector point, ref Vector force);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_in_space(WorldHandle world, uint member, ref Place place, int field,
            out Vector value);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_touches(WorldHandle world, [Out] Touch[] touches, UIntPtr capacity,
            out UIntPtr count);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_joint(WorldHandle world, uint joint, out JointState found);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_break(WorldHandle world, uint joint);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_forget(WorldHandle world);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern UIntPtr vdm_world_saved_length(WorldHandle world);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_save(WorldHandle world, [Out] double[] saved, UIntPtr length);
        [DllImport(Library, CallingConvention = CallingConvention.Cdecl)]
        public static extern int vdm_world_restore(WorldHandle world, double[] saved, UIntPtr length);
#pragma warning restore IDE1006
    }
}
