# julia response.jl, where the library is in the path of libraries
using Printf

const LIBRARY = "libvibroimpact"

struct Column  # struct vibroimpact_column of vibroimpact.h
    table::NTuple{17,UInt8}
    name::NTuple{25,UInt8}
    each::NTuple{17,UInt8}
    unit::NTuple{17,UInt8}
    label::NTuple{29,UInt8}
    meaning::NTuple{161,UInt8}
    kind::Int32
    listed::Int32
    place::Int32
    table_place::Int32
    n_dims::Int32
    shape::NTuple{4,Int32}
    n_words::Int32
    x::Ptr{Float64}
    k::Ptr{Int32}
end

mutable struct Result
    handle::Int64
    function Result(text; threads = 0)
        handle = Ref{Int64}(0)
        status = ccall((:vibroimpact_run, LIBRARY), Cint, (Cstring, Cint, Ptr{Int32}, Ref{Int64}),
                       text, threads, C_NULL, handle)
        result = finalizer(new(handle[])) do x
            ccall((:vibroimpact_free, LIBRARY), Cvoid, (Int64,), x.handle)
        end
        status == 2 && error(words(result, 0))
        return result
    end
end

function words(result, what)
    room = ccall((:vibroimpact_text, LIBRARY), Csize_t, (Int64, Cint, Ptr{UInt8}, Csize_t),
                 result.handle, what, C_NULL, 0) + 1
    out = Vector{UInt8}(undef, room)
    ccall((:vibroimpact_text, LIBRARY), Csize_t, (Int64, Cint, Ptr{UInt8}, Csize_t),
          result.handle, what, out, room)
    return String(out[1:end-1])
end

# A copy of the numbers of a column, with the dimensions of its table.
function column(result, table, name)
    found = Ref{Column}()
    status = ccall((:vibroimpact_find, LIBRARY), Cint, (Int64, Cstring, Cstring, Ref{Column}),
                   result.handle, table, name, found)
    status == 0 || error("no column $name in $table")
    shape = Tuple(Int.(found[].shape[1:found[].n_dims]))
    GC.@preserve result return copy(unsafe_wrap(Array, found[].x, shape))
end

result = Result("""
&system xi = 0.0114, mu = 0.028, restitution = 0.75 /
&response r_min = 1.00, r_max = 1.04, r_points = 5, clearance = 25, states = 6 /
""")
for row in zip(column(result, "points", "r"), column(result, "points", "lowest"), column(result, "points", "highest"))
    @printf("%.2f %.10f %.10f\n", row...)
end
